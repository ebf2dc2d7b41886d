// The part of BodyCompiler that reads spline blocks and what stands behind WITH.
#include <algorithm>
#include <utility>

#include "tools/sim/krl/body_compiler.hpp"

namespace truepose::sim::krl {
namespace {

bool belongs(std::string_view segment, MotionKind block) {
  if (block == MotionKind::PtpSpline) return segment == "SPTP";
  return segment == "SPL" || segment == "SLIN" || segment == "SCIRC";
}

}  // namespace

void BodyCompiler::compile_spline(TokenReader& reader) {
  attempt([&] { compile_block(reader); },
          [this, first = at_] {
            for (at_ = first; !at_end() && !next_begins_with("ENDSPLINE");) ++at_;
            if (at_end()) return false;
            ++at_;
            return true;
          });
}

void BodyCompiler::compile_block(TokenReader& reader) {
  const Statement& opened = body_.statements[at_ - 1];
  const Token word = reader.take();
  const std::vector<Assignment> settings = read_settings(reader);
  reader.expect_end();
  MotionShape block{.kind = word.is("SPLINE") ? MotionKind::Spline : MotionKind::PtpSpline,
                    .settings = settings.size()};
  block.segments = segments(block.kind, opened);
  StatementReader end(body_.file->name, body_.statements[at_++]);
  end.expect("ENDSPLINE");
  block.approximation = read_approximation(end, true);
  end.expect_end();
  scope_.line = opened[0].line;
  emit_settings(settings);
  symbols_.program.motions.push_back(std::move(block));
  scope_.emit(Op::Move, symbols_.program.motions.size() - 1);
}

std::vector<MotionShape> BodyCompiler::segments(MotionKind block, const Statement& opened) {
  const std::string takes = block == MotionKind::Spline
                                ? "SPLINE takes SPL, SLIN, SCIRC, TRIGGER and TIME_BLOCK"
                                : "PTP_SPLINE takes SPTP and TRIGGER";
  std::vector<MotionShape> segments;
  std::vector<TriggerShape> triggers;
  while (!next_begins_with("ENDSPLINE")) {
    if (at_end()) throw Fault{body_.file->name, opened[0].line, "ENDSPLINE is missing"};
    const Statement& statement = body_.statements[at_++];
    scope_.line = statement[0].line;
    StatementReader reader(body_.file->name, statement);
    if (reader.next_is("TRIGGER")) {
      triggers.push_back(read_trigger(reader, true));
    } else if (reader.next_is("TIME_BLOCK") && block == MotionKind::Spline) {
      read_time(reader, segments);
    } else if (belongs(reader.peek().word(), block)) {
      segments.push_back(motion_shape(reader));
      segments.back().triggers = std::exchange(triggers, {});
    } else {
      reader.fail(takes + ", not " + reader.peek().word());
    }
    reader.expect_end();
  }
  if (segments.empty() || !triggers.empty())
    throw Fault{body_.file->name, body_.statements[at_][0].line, "a segment is expected before ENDSPLINE"};
  return segments;
}

/// TIME_BLOCK START, PART=percent, END=seconds: how long which segments take.
void BodyCompiler::read_time(TokenReader& reader, std::vector<MotionShape>& segments) {
  reader.expect("TIME_BLOCK");
  if (reader.take_if("START")) return;
  const bool is_part = reader.take_if("PART");
  if (!is_part && !reader.take_if("END")) reader.fail("START, PART or END is expected behind TIME_BLOCK");
  if (segments.empty()) reader.fail("TIME_BLOCK stands behind the segments that it is about");
  reader.expect("=");
  expressions_.value_as(read_expression(reader), {Kind::Real}, "the time of TIME_BLOCK");
  bool& ends = is_part ? segments.back().ends_part : segments.back().ends_time;
  if (ends || segments.back().ends_time) reader.fail("TIME_BLOCK END comes once, behind all parts");
  ends = true;
}

void BodyCompiler::emit_settings(const std::vector<Assignment>& settings) {
  for (const auto& [variable, value] : settings) {
    const std::string& name = variable.root().name;
    const Symbol symbol = scope_.variable(name);
    if (symbol.storage != Storage::System || !symbol.passes_advance_run || symbol.is_constant)
      scope_.fail("WITH sets what motions take with them, such as $VEL.CP, not " + name);
    const Type type = expressions_.place(variable);
    if (type.is_array()) scope_.fail("WITH sets one element of " + name);
    expressions_.value_as(value, type, "the variable " + name);
  }
}

}  // namespace truepose::sim::krl
