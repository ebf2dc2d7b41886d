// The part of BodyCompiler that reads PULSE and $CYCFLAG.
#include "tools/sim/krl/body_compiler.hpp"

namespace truepose::sim::krl {

void BodyCompiler::compile_pulse(TokenReader& reader) {
  read_pulse(reader);
  reader.expect_end();
}

/// PULSE($OUT[1],TRUE,0.5): a signal, its level, and for how many seconds.
void BodyCompiler::read_pulse(TokenReader& reader) {
  const Expression pulse = read_call(reader);
  if (pulse.parts.size() != 3) reader.fail("PULSE takes an output, its level and a time in seconds");
  if (!expressions_.place(pulse.parts[0]).is(Kind::Bool)) reader.fail("PULSE takes an output, a BOOL");
  expressions_.value_as(pulse.parts[1], {Kind::Bool}, "the level of PULSE");
  expressions_.value_as(pulse.parts[2], {Kind::Real}, "the time of PULSE");
  scope_.emit(Op::Pulse);
}

void BodyCompiler::compile_cyclical(TokenReader& reader) {
  const Expression flag = read_variable(reader);
  if (flag.kind != ExpressionKind::Element || flag.parts.size() != 2)
    reader.fail("$CYCFLAG is set with its number: $CYCFLAG[1]");
  expressions_.value_as(flag.parts[1], {Kind::Int}, "the number of $CYCFLAG");
  reader.expect("=");
  scope_.emit(Op::Cycle, symbols_.program.cycles.size());
  const std::size_t over = scope_.emit(Op::Jump);
  symbols_.program.cycles.push_back(scope_.here());
  scope_.aside = "cyclical flag";
  condition(reader, "the cyclical flag");
  scope_.aside = {};
  scope_.emit(Op::Done);
  scope_.land(over);
  reader.expect_end();
}

}  // namespace truepose::sim::krl
