// The part of Interpreter that carries out PULSE, $CYCFLAG and ON_ERROR_PROCEED.
#include <utility>

#include "tools/sim/krl/interpreter.hpp"

namespace truepose::sim::krl {

void Interpreter::pulse() {
  const std::chrono::duration<double> lasts{number_of(evaluator_.pop())};
  const bool level = evaluator_.pop_bool();
  Place output = evaluator_.pop_place();
  constexpr std::chrono::duration<double> kLeast{0.012}, kMost{2.0};  // what the pendant's inline form takes
  if (lasts < kLeast || lasts > kMost) throw Fault{.what = "the time of PULSE is 0.012 to 2 s"};
  evaluator_.store(output, level);
  std::erase_if(pulses_, [&](const Pulse& other) {
    return other.output.slot == output.slot && other.output.path == output.path;
  });
  pulses_.push_back({std::move(output), !level, now_ + std::chrono::round<Time>(lasts)});
}

void Interpreter::end_pulses() {
  for (const Pulse& pulse : pulses_) {
    if (pulse.ends <= now_) evaluator_.store(pulse.output, pulse.level);
  }
  std::erase_if(pulses_, [this](const Pulse& pulse) { return pulse.ends <= now_; });
}

void Interpreter::set_cycle(std::size_t cycle, int flag) {
  cycles_[flag] = cycle;
  set_cyclical_flags();
}

void Interpreter::set_cyclical_flags() {
  for (const auto& [flag, cycle] : cycles_) {
    evaluator_.execute_all(cycle);
    if (const auto set = host_.write("$CYCFLAG", flag, evaluator_.pop_bool()); !set)
      throw Fault{.what = set.error()};
  }
}

bool Interpreter::proceed_after_error(int number) {
  if (frames_.empty() || std::exchange(frames_.back().proceeds, 0) != 1) return false;
  Frame& frame = frames_.back();
  evaluator_.operands.resize(frame.operands);
  frame.wait = {};
  frame.calls_again = false;
  has_changed_ = true;
  while (program_.code[frame.at].op != Op::Statement) ++frame.at;
  constexpr std::int64_t kNumber = 0;  // the first component of ERROR_T
  if (const auto error = program_.find_system("$ERR"))
    evaluator_.store({.storage = Storage::System, .slot = *error, .path = {kNumber}}, std::int32_t{number});
  return true;
}

}  // namespace truepose::sim::krl
