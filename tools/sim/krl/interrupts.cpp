// The part of Interpreter that handles interrupts, BRAKE and RESUME.
#include <algorithm>
#include <limits>
#include <utility>

#include "tools/sim/krl/interpreter.hpp"

namespace truepose::sim::krl {
namespace {

constexpr int kLowestPriority = 128;

}  // namespace

void Interpreter::declare_interrupt(std::size_t shape) {
  const int priority = evaluator_.pop_int();
  if (priority < 1 || priority > kLowestPriority)
    throw Fault{.what = "the number of an interrupt is 1 to " + std::to_string(kLowestPriority)};
  const std::size_t level = frames_.size() - 1;
  std::erase_if(interrupts_,
                [&](const Interrupt& other) { return other.priority == priority && other.level == level; });
  interrupts_.push_back({.priority = priority, .shape = shape, .level = level});
}

/// The declaration made last holds until its subprogram ends.
Interpreter::Interrupt* Interpreter::effective(int priority) {
  const auto at = std::find_if(interrupts_.rbegin(), interrupts_.rend(),
                               [&](const Interrupt& other) { return other.priority == priority; });
  return at == interrupts_.rend() ? nullptr : &*at;
}

void Interpreter::switch_interrupt(InterruptSwitch to, std::optional<int> priority) {
  if (priority && !effective(*priority))
    throw Fault{.what = "the interrupt " + std::to_string(*priority) + " is not declared",
                .number = kNoInterruptError};
  for (Interrupt& interrupt : interrupts_) {
    if (priority ? &interrupt != effective(*priority) : &interrupt != effective(interrupt.priority)) continue;
    switch (to) {
      case InterruptSwitch::On:
        // Only what changes from now on is an edge.
        interrupt.was_true = is_true(interrupt);
        interrupt.is_pending = interrupt.is_pending && interrupt.is_on;
        interrupt.is_on = interrupt.is_enabled = true;
        break;
      case InterruptSwitch::Off:
        interrupt.is_on = interrupt.is_pending = false;
        break;
      case InterruptSwitch::Enable:
      case InterruptSwitch::Disable:
        interrupt.is_enabled = to == InterruptSwitch::Enable;
        break;
    }
  }
}

bool Interpreter::is_true(const Interrupt& interrupt) {
  evaluator_.execute_all(program_.interrupts[interrupt.shape].condition);
  return evaluator_.pop_bool();
}

std::optional<std::size_t> Interpreter::interrupt_frame() const {
  for (std::size_t i = frames_.size(); i-- > 0;) {
    if (frames_[i].interruption) return i;
  }
  return std::nullopt;
}

void Interpreter::look_at_interrupts() {
  if (!has_changed_) return;
  set_cyclical_flags();
  const bool was_triggered = look_at_triggers();
  const auto running = interrupt_frame();
  int most = running ? frames_[*running].interruption->priority : std::numeric_limits<int>::max();
  Interrupt* next = nullptr;
  for (Interrupt& interrupt : interrupts_) {
    if (!interrupt.is_on || effective(interrupt.priority) != &interrupt) continue;
    const bool is_now = is_true(interrupt);
    if (is_now && !interrupt.was_true) interrupt.is_pending = true;
    interrupt.was_true = is_now;
    if (interrupt.is_pending && interrupt.is_enabled && interrupt.priority < most) {
      next = &interrupt;
      most = interrupt.priority;
    }
  }
  has_changed_ = was_triggered || next != nullptr;
  if (!next) return;
  next->is_pending = false;
  host_.interrupted();
  fire(program_.interrupts[next->shape].call, {.priority = next->priority, .level = next->level});
}

void Interpreter::fire(std::size_t action, Interruption interruption) {
  interruption.switching = std::exchange(switching_, {});
  evaluator_.locals.emplace_back();
  frames_.push_back(
      {.at = action, .operands = evaluator_.operands.size(), .interruption = std::move(interruption)});
}

bool Interpreter::is_braked() const {
  return std::ranges::any_of(
      frames_, [](const Frame& frame) { return frame.interruption && frame.interruption->holds; });
}

void Interpreter::brake(bool with_all_force) {
  const auto at = interrupt_frame();
  if (!at) throw Fault{.what = "BRAKE stands outside of an interrupt program"};
  if (kind_ == InterpreterKind::Submit) throw Fault{.what = "a submit program must not brake the arm"};
  frames_[*at].interruption->may_move = frames_[*at].interruption->holds = true;
  host_.brake(with_all_force);
  wait_for({.what = WaitFor::Standstill});
}

bool Interpreter::end_interruption() {
  Interruption& interruption = *frames_.back().interruption;
  if (interruption.moves && !interruption.holds && unfinished() > 0) {
    --frames_.back().at;
    wait_for({.what = WaitFor::Arrival});
    return false;
  }
  if (std::exchange(interruption.holds, false) && !is_braked()) host_.go_on();
  for (Motion& motion : std::exchange(interruption.parked, {})) hand_over(std::move(motion));
  switching_ = std::move(interruption.switching);
  // A motion that is handed over again belongs to an interrupt that holds the arm itself.
  if (interruption.moves && is_braked()) host_.brake(false);
  return true;
}

void Interpreter::resume() {
  const auto at = interrupt_frame();
  if (!at) throw Fault{.what = "RESUME stands outside of an interrupt program"};
  const auto level = frames_[*at].interruption->level;
  const bool is_below = level && *level + 1 < *at && !frames_[*level + 1].interruption;
  if (!is_below)
    throw Fault{.what =
                    "RESUME needs a running subprogram that was called where the interrupt is declared; "
                    "unless $ADVANCE is 0 the advance run may have left it"};
  Frame& target = frames_[*level];
  const Instruction& call = program_.code[target.at - 1];
  const bool is_dropped = call.b != 0 && program_.code[target.at].op == Op::Drop;
  if (call.b != 0 && !is_dropped) throw Fault{.what = "RESUME would return into the middle of an expression"};
  if (is_dropped) ++target.at;
  while (frames_.size() > *level + 1) pop_frame();
  if (kind_ == InterpreterKind::Submit) return;
  sent_.clear();
  triggers_.clear();
  switching_.clear();
  host_.cancel();
  wait_for({.what = WaitFor::Standstill});
}

}  // namespace truepose::sim::krl
