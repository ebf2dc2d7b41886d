// The part of BodyCompiler that reads TRIGGER.
#include "tools/sim/krl/body_compiler.hpp"

namespace truepose::sim::krl {

void BodyCompiler::compile_trigger(TokenReader& reader) {
  if (body_.is_submit) reader.fail("a submit program moves no arm that could trigger");
  symbols_.program.triggers.push_back(read_trigger(reader, false));
  reader.expect_end();
  scope_.emit(Op::Trigger, symbols_.program.triggers.size() - 1);
}

TriggerShape BodyCompiler::read_trigger(TokenReader& reader, bool in_spline) {
  reader.expect("TRIGGER");
  reader.expect("WHEN");
  TriggerShape trigger;
  read_switching_point(reader, in_spline, trigger);
  reader.expect("DELAY");
  reader.expect("=");
  expressions_.value_as(read_expression(reader), {Kind::Real}, "DELAY");
  reader.expect("DO");
  const std::size_t over = scope_.emit(Op::Jump);
  trigger.action = scope_.here();
  trigger.is_call = reader.peek(1).is("(") && !reader.next_is("PULSE");
  trigger.is_call ? call_out_of_sequence(reader) : set_out_of_sequence(reader);
  scope_.land(over);
  if (!trigger.is_call) return trigger;
  if (!reader.take_if("PRIO")) reader.fail("a subprogram that is triggered needs PRIO");
  reader.expect("=");
  expressions_.value_as(read_expression(reader), {Kind::Int}, "PRIO");
  return trigger;
}

void BodyCompiler::set_out_of_sequence(TokenReader& reader) {
  scope_.aside = "trigger";
  if (reader.next_is("PULSE")) {
    read_pulse(reader);
  } else {
    const Assignment assignment = read_assignment(reader);
    expressions_.assign(assignment.variable, assignment.value);
  }
  scope_.aside = {};
  scope_.emit(Op::Return);
}

/// DISTANCE=0, the start of the motion; DISTANCE=1, its end; PATH=mm from its end, or with ONSTART its start.
void BodyCompiler::read_switching_point(TokenReader& reader, bool in_spline, TriggerShape& trigger) {
  if (reader.take_if("PATH")) {
    reader.expect("=");
    expressions_.value_as(read_expression(reader), {Kind::Real}, "PATH");
    trigger.from_start = reader.take_if("ONSTART");
    return;
  }
  if (in_spline) reader.fail("in a spline block PATH is expected");
  if (!reader.take_if("DISTANCE")) reader.fail("DISTANCE or PATH is expected");
  reader.expect("=");
  const std::string end = reader.take().word();
  if (end != "0" && end != "1") reader.fail("DISTANCE is 0, the start of the motion, or 1, its end");
  trigger.from_start = end == "0";
  scope_.push(0.0);
}

}  // namespace truepose::sim::krl
