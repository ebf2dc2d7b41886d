#pragma once

#include <chrono>
#include <deque>
#include <functional>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "tools/sim/krl/interpreter.hpp"
#include "tools/sim/krl/load.hpp"

namespace truepose::sim::krl {

using namespace std::chrono_literals;

/// A controller whose arm needs the same time for each motion and stops a while after it was braked.
class FakeHost : public Host {
 public:
  Value read(const Variable& variable, std::optional<int> index) override;
  std::expected<void, std::string> write(std::string_view name, std::optional<int> index,
                                         const Value& value) override;
  std::expected<CallResult, std::string> call(ExternalCall& call) override;
  std::expected<void, std::string> move(const Motion& motion) override;
  bool is_finished(std::uint64_t motion) override;
  /// A motion of 1000 mm is made in motion_time.
  std::vector<std::uint64_t> take_switched() override;
  bool is_standing() override;
  void brake(bool with_all_force) override;
  void go_on() override;
  void cancel() override;
  void show(const Message& message) override { messages.push_back(message.text); }

  void set(const std::string& name, Value value) { variables[name] = std::move(value); }
  /// Lets time pass up to `to`.
  void advance(Time to);
  /// When the arm next ends a motion or comes to a stand.
  std::optional<Time> next_change() const;

  Time now{0};
  Time motion_time = 1s;
  Time braking_time = 100ms;
  std::map<std::string, Value> variables;  ///< "$FLAG[103]", "$OV_PRO"
  /// The same, that the controller writes again in every cycle.
  std::map<std::string, std::function<Value(Time)>> rewritten;
  std::function<std::expected<CallResult, std::string>(ExternalCall&)> on_call;
  std::function<void(const Motion&)> on_arrival;
  std::vector<std::string> log;  ///< "move 1", "1 is made", "brake", "go on", "cancel"
  std::vector<Motion> moved;
  std::vector<std::string> messages;

 private:
  struct Making {
    Motion motion;
    Time left;
  };
  void plan_switches(const Motion& motion);
  std::deque<Making> making_;
  std::map<std::uint64_t, Time> switches_;  // as long as nothing brakes
  std::map<int, Time> timer_zero_;          // when a running timer is 0
  std::optional<Time> braked_;
};

/// Sources, loaded and run against a FakeHost. Throws std::runtime_error where they do not load.
class Bench {
 public:
  /// @param declarations  in addition to the controller's
  /// @param pass_advance_run  names that do not stop it
  explicit Bench(std::vector<Source> sources, const std::string& declarations = "",
                 std::vector<std::string> pass_advance_run = {});

  /// Selects and starts.
  Interpreter& start(const std::string& name, InterpreterKind kind = InterpreterKind::Robot);
  /// Runs all interpreters and the arm for a while.
  void run_for(Time time);
  /// Until nothing more happens by itself.
  void run_until_quiet() { run_for(100s); }

  /// A variable of a module.
  Value variable(const std::string& name) const;
  int integer(const std::string& name) const { return std::get<std::int32_t>(variable(name)); }
  double real(const std::string& name) const { return std::get<double>(variable(name)); }

  FakeHost host;
  Program program;
  Memory memory;
  std::deque<Interpreter> interpreters;
};

/// Declarations of a controller in addition to the interpreter's, and `declarations`.
Environment cell(const std::string& declarations = "");

/// A main program P whose statements stand between DEF and END; `data` and `more` stand in its data list and
/// behind it.
std::vector<Source> program_of(const std::string& statements, const std::string& data = "",
                               const std::string& more = "");

/// "p.src:3: ..." of sources that must not load; empty where they do.
std::string load_error(const std::vector<Source>& sources, const std::string& declarations = "");

}  // namespace truepose::sim::krl
