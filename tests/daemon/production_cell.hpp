#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/math/random.hpp"
#include "daemon/realtime/stream_cycle.hpp"
#include "tests/daemon/plant.hpp"
#include "tests/daemon/stream_cell.hpp"
#include "tools/sim/krl/interpreter.hpp"
#include "tools/sim/krl/load.hpp"
#include "tools/sim/motion/program_motion.hpp"

namespace truepose::daemon {

/// How wrong the TCP was at the points of a program, mm.
struct TcpErrors {
  int points = 0;
  double mean_mm = 0, max_mm = 0;

  void add(double mm);
};

/// What befalls a shift; each so many times.
struct Troubles {
  int daemon_ends = 0;  ///< half of them for longer than the controller waits
  int stops = 0;        ///< of the program, and resumed
  int emergency_stops = 0;
  int controller_restarts = 0;
  double loss = 0;  ///< share of the datagrams and of the replies, in bursts
};

/// What became of a shift.
struct Production {
  std::uint64_t cycles = 0;           ///< of the controller
  std::uint64_t sessions = 0;         ///< of RSI, opened by programs
  int programs = 0;                   ///< that came to their end
  int timeouts = 0;                   ///< sessions that the controller gave up
  double max_step_deg = 0;            ///< of a correction in effect, but for those that RSI took away
  double left_deg = 0;                ///< greatest correction in effect where a program closed RSI
  double largest_deg = 0;             ///< correction
  TcpErrors with, without;            ///< the stream, at the points where all of the correction was in effect
  int points_without_it = 0;          ///< passed while the daemon was away or ramped in
  std::vector<std::string> messages;  ///< on the pendant, each once
  std::string fault;                  ///< of the stream, the first
  Troubles never_came;                ///< of those that were ordered
};

/// Whether the advance run stops at system variables of which no manual says it: none says that it does not.
enum class AdvanceRun { StopsAtVariables, PassesVariables };

/// A controller that runs a customer's program and the shipped truepose_stream, its drives, and an armed
/// stream: cycle by cycle, in virtual time. The arm is wrong as the published one is, and the model knows it.
class ProductionCell final : private sim::krl::Host {
 public:
  /// @param program  GLUING, or one of tests/proto/krl_corpus/stream, as the pendant writes them
  ProductionCell(std::uint64_t seed, const Troubles& troubles,
                 AdvanceRun advance_run = AdvanceRun::StopsAtVariables,
                 const std::string& program = "GLUING");
  ~ProductionCell() override;

  /// Runs the program again and again.
  Production shift(int programs);

 private:
  sim::krl::Value read(const sim::krl::Variable& variable, std::optional<int> index) override;
  std::expected<void, std::string> write(std::string_view name, std::optional<int> index,
                                         const sim::krl::Value& value) override;
  std::expected<sim::krl::CallResult, std::string> call(sim::krl::ExternalCall& call) override;
  std::expected<void, std::string> move(const sim::krl::Motion& motion) override;
  std::vector<std::uint64_t> take_switched() override { return motion_.take_switched(); }
  bool is_finished(std::uint64_t motion) override { return motion_.is_finished(motion); }
  bool is_standing() override { return motion_.is_standing(); }
  void brake(bool) override { motion_.brake(); }
  void go_on() override { motion_.go_on(); }
  void cancel() override { motion_.cancel(); }
  void show(const sim::krl::Message& message) override { say(message.text); }

  std::string stuck() const;
  void cycle();
  void start_daemon();
  void end_daemon(int cycles);
  void befall();
  bool due(int& left);
  void exchange(const test::Plant::Sent& sent);
  std::string frame(const test::Plant::Sent& sent);
  void open_rsi();
  void close_rsi();
  void restart_program();
  void judge();
  void say(const std::string& text);
  Eigen::Isometry3d frame_of(const char* variable);

  Random random_;
  Troubles troubles_;
  RobotModel nominal_, real_;
  rsi::EthernetConfig config_;
  rsi::SensorFrameCodec codec_;
  sim::ProgramMotion motion_;
  test::Plant plant_;
  sim::krl::Program program_;
  sim::krl::Memory memory_;
  sim::krl::Interpreter interpreter_;
  StreamPage page_;
  std::unique_ptr<StreamMemory> stream_memory_;
  std::unique_ptr<StreamCycle> stream_;
  std::map<std::string, sim::krl::Value> variables_;
  drivers::TimePoint now_{std::chrono::hours{1}};
  JointVector actual_;
  bool rsi_on_ = false;
  std::int32_t gain_ = 0;  // word of the session's last reply
  int daemon_down_ = 0, stopped_ = 0, burst_ = 0;
  std::uint64_t made_before_ = 0;
  int judge_in_ = 0;
  double programs_left_ = 0;
  Production shift_;
};

}  // namespace truepose::daemon
