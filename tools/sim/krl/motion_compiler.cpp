// The part of BodyCompiler that moves, waits and handles interrupts.
#include <map>
#include <utility>

#include "tools/sim/krl/body_compiler.hpp"

namespace truepose::sim::krl {
namespace {

const std::map<std::string_view, Approximation> kApproximations = {{"C_PTP", Approximation::Ptp},
                                                                   {"C_DIS", Approximation::Dis},
                                                                   {"C_VEL", Approximation::Vel},
                                                                   {"C_ORI", Approximation::Ori}};
const std::map<std::string_view, InterruptSwitch> kSwitches = {{"ON", InterruptSwitch::On},
                                                               {"OFF", InterruptSwitch::Off},
                                                               {"ENABLE", InterruptSwitch::Enable},
                                                               {"DISABLE", InterruptSwitch::Disable}};

}  // namespace

const std::map<std::string_view, MotionKind>& BodyCompiler::motions() {
  static const std::map<std::string_view, MotionKind> kMotions = {
      {"PTP", MotionKind::Ptp},         {"LIN", MotionKind::Lin},        {"CIRC", MotionKind::Circ},
      {"PTP_REL", MotionKind::PtpRel},  {"LIN_REL", MotionKind::LinRel}, {"SPTP", MotionKind::Ptp},
      {"SLIN", MotionKind::Lin},        {"SCIRC", MotionKind::Circ},     {"SPTP_REL", MotionKind::PtpRel},
      {"SLIN_REL", MotionKind::LinRel}, {"SPL", MotionKind::Spl}};
  return kMotions;
}

void BodyCompiler::compile_motion(TokenReader& reader) {
  const bool is_spline = reader.peek().word().starts_with('S');
  MotionShape motion = motion_shape(reader);
  motion.approximation = read_approximation(reader, is_spline);
  reader.expect_end();
  symbols_.program.motions.push_back(std::move(motion));
  scope_.emit(Op::Move, symbols_.program.motions.size() - 1);
}

MotionShape BodyCompiler::motion_shape(TokenReader& reader) {
  if (body_.is_submit) reader.fail("a submit program must not move the arm");
  const truepose::krl::Motion motion = read_motion(reader);
  if (motion.targets.empty()) reader.fail("a value is expected");
  if (motion.targets.size() < motion.target_count()) reader.expect(",");
  MotionShape shape{.kind = motions().at(motion.word),
                    .has_angle = motion.angle.has_value(),
                    .settings = motion.settings.size(),
                    .is_in_tool = motion.frame == "TOOL"};
  compile_targets(motion, shape);
  if (motion.angle) expressions_.value_as(*motion.angle, {Kind::Real}, "the angle CA");
  emit_settings(motion.settings);
  return shape;
}

void BodyCompiler::compile_targets(const truepose::krl::Motion& motion, MotionShape& shape) {
  const bool is_arc = shape.kind == MotionKind::Circ;
  if (is_arc) shape.via = expressions_.target(motion.targets[0]);
  shape.target = expressions_.target(motion.targets.back());
  const auto is_axes = [&](const Type& type) {
    return scope_.types().structure(type).find("A1").has_value();
  };
  const bool is_on_path = shape.kind != MotionKind::Ptp && shape.kind != MotionKind::PtpRel;
  const bool goes_by_axes = is_axes(shape.target) || (is_arc && is_axes(shape.via));
  if (is_on_path && goes_by_axes) scope_.fail(motion.word + " goes to a position or frame, not to axes");
}

Approximation BodyCompiler::read_approximation(TokenReader& reader, bool is_spline) {
  if (is_spline && reader.take_if("C_SPL")) return Approximation::Spl;
  Approximation first = Approximation::None;
  for (int i = 0; i < 2 && !reader.at_end(); ++i) {
    const auto approximation = kApproximations.find(reader.peek().word());
    if (approximation == kApproximations.end()) break;
    reader.take();
    // PTP ... C_PTP C_DIS: the second is for the change to a path, with which the first begins.
    if (i == 0) first = approximation->second;
  }
  // Programs of KSS 8.6 write SLIN ... C_DIS: a spline motion knows one approximation alone.
  return is_spline && first != Approximation::None ? Approximation::Spl : first;
}

void BodyCompiler::compile_wait(TokenReader& reader) {
  reader.take();
  const bool is_time = reader.take_if("SEC");
  if (!is_time) reader.expect("FOR");
  scope_.stop_advance_run();
  scope_.is_continued = true;
  if (is_time) {
    const Type type = expressions_.value(read_expression(reader));
    if (!type.is_number()) scope_.fail("the time to wait is a number, not " + scope_.types().name(type));
    scope_.emit(Op::WaitSec);
  } else {
    const std::size_t start = scope_.here();
    condition(reader, "the condition of WAIT FOR");
    scope_.emit(Op::WaitFor, start);
  }
  reader.expect_end();
}

void BodyCompiler::compile_interrupt(TokenReader& reader) {
  const bool is_global = reader.take_if("GLOBAL");
  reader.expect("INTERRUPT");
  if (reader.take_if("DECL")) return declare_interrupt(reader, is_global);
  const auto kind = kSwitches.find(reader.peek().word());
  if (is_global || kind == kSwitches.end()) reader.fail("DECL, ON, OFF, ENABLE or DISABLE is expected");
  reader.take();
  const bool has_number = !reader.at_end();
  if (has_number) expressions_.value_as(read_expression(reader), {Kind::Int}, "the number of the interrupt");
  reader.expect_end();
  scope_.emit(Op::SwitchInterrupt, static_cast<std::size_t>(kind->second), has_number ? 1 : 0);
}

void BodyCompiler::declare_interrupt(TokenReader& reader, bool is_global) {
  expressions_.value_as(read_expression(reader), {Kind::Int}, "the number of the interrupt");
  reader.expect("WHEN");
  scope_.emit(Op::DeclareInterrupt, symbols_.program.interrupts.size());
  const std::size_t over = scope_.emit(Op::Jump);
  InterruptShape interrupt{.condition = scope_.here(), .is_global = is_global};
  scope_.aside = "interrupt";
  condition(reader, "the condition of the interrupt");
  scope_.emit(Op::Done);
  reader.expect("DO");
  interrupt.call = scope_.here();
  scope_.aside = {};
  call_out_of_sequence(reader);
  reader.expect_end();
  symbols_.program.interrupts.push_back(interrupt);
  scope_.land(over);
}

void BodyCompiler::call_out_of_sequence(TokenReader& reader) {
  const Expression call = read_call(reader);
  const std::vector<Field> locals = std::exchange(scope_.locals, {});
  expressions_.call_statement(call);
  if (!scope_.locals.empty()) scope_.fail("a call here leaves out no parameter that is OUT");
  scope_.locals = locals;
  scope_.emit(Op::Return);
}

void BodyCompiler::compile_brake(TokenReader& reader) {
  if (body_.is_submit) reader.fail("a submit program must not brake the arm");
  reader.take();
  const bool is_hard = reader.take_if("F");
  reader.expect_end();
  scope_.emit(Op::Brake, is_hard ? 1 : 0);
}

}  // namespace truepose::sim::krl
