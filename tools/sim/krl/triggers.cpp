// The part of Interpreter that carries out TRIGGER.
#include <algorithm>
#include <limits>

#include "tools/sim/krl/interpreter.hpp"

namespace truepose::sim::krl {
namespace {

constexpr int kBeforeAll = 0;        // of an assignment
constexpr int kFirstAutomatic = 40;  // to 80: what PRIO=-1 chooses from

int checked_priority(int priority) {
  const bool is_free =
      (priority >= 1 && priority <= 39 && priority != 3) || (priority >= 81 && priority <= 128);
  if (priority == -1) return kFirstAutomatic;
  if (!is_free) throw Fault{.what = "PRIO is 1, 2, 4 to 39, 81 to 128, or -1"};
  return priority;
}

}  // namespace

SwitchingPoint Interpreter::pop_switching_point(const TriggerShape& shape) {
  const int priority = shape.is_call ? checked_priority(evaluator_.pop_int()) : kBeforeAll;
  SwitchingPoint point{.number = ++points_, .from_start = shape.from_start};
  constexpr double kMsPerS = 1000;
  point.delay_s = number_of(evaluator_.pop()) / kMsPerS;
  point.path_mm = number_of(evaluator_.pop());
  triggers_.push_back({.number = point.number, .action = shape.action, .priority = priority});
  return point;
}

bool Interpreter::look_at_triggers() {
  if (triggers_.empty()) return false;
  for (const std::uint64_t number : host_.take_switched()) {
    const auto trigger = std::ranges::find(triggers_, number, &Trigger::number);
    if (trigger != triggers_.end()) trigger->is_switched = true;
  }
  const auto running = interrupt_frame();
  const int most = running ? frames_[*running].interruption->priority : std::numeric_limits<int>::max();
  const auto rank = [](const Trigger& trigger) {
    return trigger.is_switched ? trigger.priority : std::numeric_limits<int>::max();
  };
  const auto next = std::ranges::min_element(triggers_, {}, rank);
  if (rank(*next) >= most) return false;
  const Trigger trigger = *next;
  triggers_.erase(next);
  fire(trigger.action, {.priority = trigger.priority, .level = std::nullopt});
  return true;
}

}  // namespace truepose::sim::krl
