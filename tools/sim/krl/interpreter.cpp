#include "tools/sim/krl/interpreter.hpp"

#include <algorithm>
#include <utility>

#include "tools/sim/krl/builtins.hpp"
#include "tools/sim/krl/operations.hpp"

namespace truepose::sim::krl {
namespace {

/// Subprograms in one another.
constexpr std::size_t kDeepestCall = 100;

[[noreturn]] void give_up(std::string what) { throw Fault{.what = std::move(what)}; }

/// Whether an instruction changes nothing that an interrupt may wait for.
bool only_leads_on(Op op) {
  return op == Op::Statement || op == Op::Jump || op == Op::JumpUnless || op == Op::ForGoesOn ||
         op == Op::Call || op == Op::AdvanceStop || op == Op::WaitFor || op == Op::WaitSec;
}

/// A REAL of the host, at any depth, as a variable holds it.
void round_reals(Value& value) {
  if (auto* number = std::get_if<double>(&value)) *number = to_real(*number);
  if (auto* parts = std::get_if<Parts>(&value)) std::ranges::for_each(*parts, round_reals);
}

}  // namespace

Interpreter::Interpreter(const Program& program, Memory& memory, Host& host, InterpreterKind kind)
    : program_{program}, host_{host}, kind_{kind}, evaluator_{program, memory.globals, &host} {}

std::expected<void, std::string> Interpreter::select(std::string_view routine) {
  const auto found = program_.find_routine(in_capitals(routine));
  if (!found || !program_.routines[*found].is_global)
    return std::unexpected("the program " + std::string(routine) + " is not known" + why_not_loaded(routine));
  if (!program_.routines[*found].parameters.empty())
    return std::unexpected("the program " + std::string(routine) + " takes parameters");
  selected_ = *found;
  reset();
  return {};
}

/// The fault of the file that is called like it.
std::string Interpreter::why_not_loaded(std::string_view routine) const {
  for (const Fault& fault : program_.refusals) {
    const std::string file = in_capitals(fault.file.substr(fault.file.find_last_of("/\\") + 1));
    if (file == in_capitals(routine) + ".SRC") return " (" + fault.text() + ")";
  }
  return "";
}

void Interpreter::deselect() {
  reset();
  selected_.reset();
  state_ = ProgramState::Free;
}

void Interpreter::reset() {
  const bool was_moving = !sent_.empty() || !frames_.empty();
  frames_.clear();
  interrupts_.clear();
  sent_.clear();
  triggers_.clear();
  switching_.clear();
  cycles_.clear();
  evaluator_.operands.clear();
  evaluator_.locals.clear();
  fault_.reset();
  is_held_ = false;
  if (was_moving && kind_ == InterpreterKind::Robot) host_.cancel();
  state_ = selected_ ? ProgramState::Reset : ProgramState::Free;
}

bool Interpreter::start() {
  if (state_ == ProgramState::Reset) {
    enter(*selected_);
  } else if (state_ != ProgramState::Stopped || fault_) {
    return state_ == ProgramState::Active;
  } else if (std::exchange(is_held_, false)) {
    host_.go_on();
  }
  state_ = ProgramState::Active;
  return true;
}

void Interpreter::stop() {
  if (state_ != ProgramState::Active) return;
  state_ = ProgramState::Stopped;
  is_held_ = kind_ == InterpreterKind::Robot && !is_braked();
  if (is_held_) host_.brake(false);
}

void Interpreter::run(Time now) {
  now_ = now;
  end_pulses();
  if (state_ != ProgramState::Active) return;
  ++turn_;
  has_changed_ = true;
  while (true) {
    try {
      return execute_turn();
    } catch (Fault& fault) {
      if (!proceed_after_error(fault.number)) return stop_by(std::move(fault));
    }
  }
}

void Interpreter::execute_turn() {
  is_hurried_ = false;
  look_at_interrupts();
  for (int count = 0; count < kInstructionsPerTurn; ++count) {
    Wait& wait = frames_.back().wait;
    if (!is_over(wait)) return;
    wait = {};
    step();
    if (state_ != ProgramState::Active) return;
  }
  is_hurried_ = true;
}

std::optional<Time> Interpreter::next_change() const {
  std::optional<Time> next;
  for (const Pulse& pulse : pulses_) next = std::min(next.value_or(pulse.ends), pulse.ends);
  if (state_ != ProgramState::Active) return next;
  if (is_hurried_) return now_ + kTurn;
  const Wait& wait = frames_.back().wait;
  if (wait.what == WaitFor::Moment) next = std::min(next.value_or(wait.until), wait.until);
  return next;
}

int Interpreter::line() const { return frames_.empty() ? 0 : program_.code[frames_.back().at].line; }

bool Interpreter::is_over(const Wait& wait) {
  switch (wait.what) {
    case WaitFor::Nothing:
      return true;
    case WaitFor::Condition:
    case WaitFor::External:
      return wait.turn != turn_;
    case WaitFor::Moment:
      return now_ >= wait.until;
    case WaitFor::Room:
      return unfinished() <= wait.most;
    case WaitFor::Arrival:
      return unfinished() == 0;
    case WaitFor::Switching:
      return triggers_.empty();
    case WaitFor::Standstill:
      return host_.is_standing();
  }
  return true;
}

void Interpreter::stop_by(Fault fault) {
  if (fault.line == 0 && !frames_.empty()) {
    // The instruction was taken already.
    const std::size_t at = frames_.back().at;
    const Instruction& instruction = program_.code[at > 0 ? at - 1 : 0];
    fault.line = instruction.line;
    fault.file = program_.files[static_cast<std::size_t>(instruction.file)];
  }
  stop();
  state_ = ProgramState::Stopped;
  host_.show({Severity::Error, fault.text()});
  fault_ = std::move(fault);
}

void Interpreter::step() {
  Frame& frame = frames_.back();
  const Instruction& instruction = program_.code[frame.at++];
  if (instruction.op < Op::Statement) {
    evaluator_.execute(instruction);
    has_changed_ |= instruction.op == Op::Store;
  } else {
    has_changed_ |= !only_leads_on(instruction.op);
    control(instruction);
  }
}

void Interpreter::control(const Instruction& instruction) {
  Frame& frame = frames_.back();
  const auto a = static_cast<std::size_t>(instruction.a);
  switch (instruction.op) {
    case Op::Statement:
      if (frame.proceeds > 0) --frame.proceeds;
      return look_at_interrupts();
    case Op::Jump:
      frame.at = a;
      return;
    case Op::JumpUnless:
      if (!evaluator_.pop_bool()) frame.at = a;
      return;
    case Op::ForGoesOn: {
      const std::vector<Operand>& locals = evaluator_.locals.back().values;
      const auto last = std::get<std::int32_t>(std::get<Value>(locals[a]));
      const auto step_width = std::get<std::int32_t>(std::get<Value>(locals[a + 1]));
      const std::int32_t counter = evaluator_.pop_int();
      return evaluator_.push(step_width >= 0 ? counter <= last : counter >= last);
    }
    case Op::Call:
      return enter(a);
    case Op::CallExternal:
      return call_external(instruction);
    case Op::Return:
      return leave(instruction.b != 0);
    case Op::NoResult:
      give_up("the function ends without RETURN");
    case Op::AdvanceStop:
      if (awaited() > 0) wait_for({.what = WaitFor::Arrival});
      return;
    case Op::WaitFor:
      if (evaluator_.pop_bool()) return;
      frame.at = a;
      return wait_for({.what = WaitFor::Condition, .turn = turn_});
    case Op::WaitSec: {
      const std::chrono::duration<double> time{number_of(evaluator_.pop())};
      // A time that no run of a program reaches, so that the sum fits.
      constexpr std::chrono::duration<double> kLongest = std::chrono::hours{24 * 365};
      const auto bounded = std::clamp(time, std::chrono::duration<double>::zero(), kLongest);
      return wait_for({.what = WaitFor::Moment, .until = now_ + std::chrono::round<Time>(bounded)});
    }
    case Op::Halt:
      state_ = ProgramState::Stopped;
      if (kind_ == InterpreterKind::Robot) host_.halted();
      return;
    case Op::Trigger:
      return switching_.push_back(pop_switching_point(program_.triggers[a]));
    case Op::Move:
      return move(program_.motions[a]);
    case Op::Pulse:
      return pulse();
    case Op::Cycle:
      return set_cycle(program_.cycles[a], evaluator_.pop_int());
    case Op::Proceed:
      frame.proceeds = 2;
      return;
    case Op::Refuse:
      throw program_.refusals[a];
    case Op::Brake:
      return brake(instruction.a != 0);
    case Op::Resume:
      return resume();
    case Op::DeclareInterrupt:
      return declare_interrupt(a);
    case Op::SwitchInterrupt:
      return switch_interrupt(static_cast<InterruptSwitch>(instruction.a),
                              instruction.b != 0 ? std::optional<int>{evaluator_.pop_int()} : std::nullopt);
    default:
      return;
  }
}

void Interpreter::enter(std::size_t index) {
  if (frames_.size() >= kDeepestCall) give_up("too many subprograms call one another");
  const Routine& routine = program_.routines[index];
  std::vector<Operand> locals(routine.locals.begin(), routine.locals.end());
  auto& operands = evaluator_.operands;
  const std::size_t first = operands.size() - routine.parameters.size();
  std::move(operands.begin() + static_cast<std::ptrdiff_t>(first), operands.end(), locals.begin());
  operands.resize(first);
  evaluator_.locals.push_back({&routine, std::move(locals)});
  frames_.push_back({.at = routine.entry, .operands = first});
}

void Interpreter::leave(bool has_value) {
  const bool ends = frames_.size() == 1;
  if (ends && unfinished() > 0) {
    --frames_.back().at;
    return wait_for({.what = WaitFor::Arrival});
  }
  if (ends && !triggers_.empty()) {
    --frames_.back().at;
    return wait_for({.what = WaitFor::Switching});
  }
  const bool ends_interruption = frames_.back().interruption.has_value();
  if (ends_interruption && !end_interruption()) return;
  std::optional<Value> value;
  if (has_value) value = evaluator_.pop();
  pop_frame();
  if (ends) return end_program();
  // What the program waited for may have come in the interrupt program.
  Wait& wait = frames_.back().wait;
  if (wait.what == WaitFor::Condition) wait = {};
  if (value) evaluator_.push(std::move(*value));
  if (ends_interruption) look_at_interrupts();
}

void Interpreter::end_program() {
  state_ = ProgramState::Ended;
  interrupts_.clear();
}

void Interpreter::pop_frame() {
  const std::size_t level = frames_.size() - 1;
  evaluator_.operands.resize(frames_.back().operands);
  evaluator_.locals.pop_back();
  frames_.pop_back();
  std::erase_if(interrupts_, [&](const Interrupt& interrupt) {
    return interrupt.level == level && !program_.interrupts[interrupt.shape].is_global;
  });
  for (Interrupt& interrupt : interrupts_) {
    if (interrupt.level == level) interrupt.level.reset();
  }
}

void Interpreter::call_external(const Instruction& instruction) {
  const External& external = program_.externals[static_cast<std::size_t>(instruction.a)];
  const auto count = static_cast<std::size_t>(instruction.b);
  std::vector<Value> arguments = external_arguments(external, count);
  if (external.is_builtin) {
    Value result = call_builtin(external.name, arguments);
    return finish_external(external, count, arguments, std::move(result));
  }
  Frame& frame = frames_.back();
  ExternalCall call{external.name, std::move(arguments), !frame.calls_again};
  auto result = host_.call(call);
  if (!result) give_up(external.name + ": " + result.error());
  frame.calls_again = !result->is_finished;
  if (frame.calls_again) {
    --frame.at;
    return wait_for({.what = WaitFor::External, .turn = turn_});
  }
  finish_external(external, count, call.arguments, std::move(result->value));
}

std::vector<Value> Interpreter::external_arguments(const External& external, std::size_t count) {
  std::vector<Value> arguments;
  const std::size_t first = evaluator_.operands.size() - count;
  for (std::size_t i = 0; i < count; ++i) {
    const Operand& operand = evaluator_.operands[first + i];
    const bool is_out = std::holds_alternative<Place>(operand);
    const bool is_text = is_out && i < external.parameters.size() && external.parameters[i].type.is_text();
    if (is_text && !std::holds_alternative<std::string>(evaluator_.look(std::get<Place>(operand))))
      give_up("a text that " + external.name + " changes has no value");
    arguments.push_back(is_out ? evaluator_.look(std::get<Place>(operand)) : std::get<Value>(operand));
  }
  return arguments;
}

void Interpreter::finish_external(const External& external, std::size_t count, std::vector<Value>& arguments,
                                  Value result) {
  const std::size_t first = evaluator_.operands.size() - count;
  for (std::size_t i = 0; i < count; ++i) {
    const auto* place = std::get_if<Place>(&evaluator_.operands[first + i]);
    if (!place) continue;
    const bool is_declared = i < external.parameters.size();
    if (is_declared && !has_type(arguments[i], external.parameters[i].type, program_.types))
      give_up(external.name + " gives no " + program_.types.name(external.parameters[i].type));
    round_reals(arguments[i]);
    if (is_set(arguments[i]) || std::holds_alternative<std::string>(arguments[i]))
      evaluator_.store(*place, std::move(arguments[i]));
  }
  evaluator_.operands.resize(first);
  if (external.result.kind == Kind::None) return;
  if (!is_set(result) || !has_type(result, external.result, program_.types))
    give_up(external.name + " returns no " + program_.types.name(external.result));
  evaluator_.push(std::move(result));
}

}  // namespace truepose::sim::krl
