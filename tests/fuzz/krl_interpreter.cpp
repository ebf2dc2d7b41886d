// A KRL program on the simulated controller. What still loads runs in simulated time, under a host that gives
// every variable a value or none and refuses some: it may stop with a fault, but not crash, and time
// continues.
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "tests/fuzz/target.hpp"
#include "tools/sim/krl/controller_declarations.hpp"
#include "tools/sim/krl/interpreter.hpp"
#include "tools/sim/krl/load.hpp"

namespace truepose::fuzz {
namespace {

namespace krl = sim::krl;

/// A controller that knows little and does all at once.
class Anywhere final : public krl::Host {
 public:
  krl::Value read(const krl::Variable& variable, std::optional<int> index) override {
    const auto written = variables_.find(key(variable.name, index));
    return written == variables_.end() ? krl::Value{} : written->second;
  }
  std::expected<void, std::string> write(std::string_view name, std::optional<int> index,
                                         const krl::Value& value) override {
    if (variables_.size() > 1000) return std::unexpected("enough");
    variables_[key(name, index)] = value;
    return {};
  }
  std::expected<krl::CallResult, std::string> call(krl::ExternalCall& call) override {
    if (++calls_ % 7 == 0) return std::unexpected("refused");
    if (call.name.starts_with("EKI_")) return krl::CallResult{.value = krl::Parts{0, 0, 0, true, 0}};
    return krl::CallResult{.is_finished = calls_ % 3 != 0, .value = 0};
  }
  std::expected<void, std::string> move(const krl::Motion& motion) override {
    expect(motion.number == ++motions_, "every motion is handed over once");
    come_to(motion);
    return {};
  }
  bool is_finished(std::uint64_t motion) override { return !braked_ && motion + 1 < motions_ + calls_ % 2; }
  std::vector<std::uint64_t> take_switched() override { return std::exchange(switched_, {}); }
  bool is_standing() override { return true; }
  void brake(bool) override { braked_ = true; }
  void go_on() override { braked_ = false; }
  void cancel() override { braked_ = false; }
  void show(const krl::Message& message) override { expect(!message.text.empty(), "a message has a text"); }

 private:
  void come_to(const krl::Motion& motion) {
    for (const krl::SwitchingPoint& point : motion.switching) switched_.push_back(point.number);
    for (const krl::Motion& segment : motion.segments) come_to(segment);
  }
  static std::string key(std::string_view name, std::optional<int> index) {
    return std::string{name} + std::to_string(index.value_or(0));
  }
  std::map<std::string, krl::Value> variables_;
  std::vector<std::uint64_t> switched_;
  std::uint64_t calls_ = 0, motions_ = 0;
  bool braked_ = false;
};

}  // namespace

void krl_interpreter(std::string_view bytes) {
  // Small programs find as much, and faster.
  if (bytes.size() > 4096) return;
  const std::vector<krl::Source> sources{{"fuzz.src", std::string{bytes}}};
  const auto program = krl::load({.declarations = std::string{sim::controller_declarations()}}, sources);
  if (!program) return expect(!program.error().text().empty(), "a refusal says where and why");
  std::optional<krl::Memory> memory;
  try {
    memory.emplace(*program);
  } catch (const krl::Fault& fault) {
    return expect(!fault.what.empty(), "a refusal says why");
  }
  Anywhere host;
  for (const krl::InterpreterKind kind : {krl::InterpreterKind::Robot, krl::InterpreterKind::Submit}) {
    krl::Interpreter interpreter{*program, *memory, host, kind};
    if (!interpreter.select("FUZZ")) return;
    interpreter.start();
    for (int ms = 0; ms < 5; ++ms) interpreter.run(std::chrono::milliseconds{ms});
    interpreter.stop();
    interpreter.start();
    interpreter.run(std::chrono::milliseconds{5});
    interpreter.reset();
  }
}

}  // namespace truepose::fuzz
