// The part of Interpreter that hands motions to the host.
#include <algorithm>
#include <utility>

#include "tools/sim/krl/interpreter.hpp"

namespace truepose::sim::krl {
namespace {

constexpr std::array<std::string_view, 12> kAxisNames = {"A1", "A2", "A3", "A4", "A5", "A6",
                                                         "E1", "E2", "E3", "E4", "E5", "E6"};
constexpr std::array<std::string_view, 6> kPoseNames = {"X", "Y", "Z", "A", "B", "C"};
constexpr std::array<std::string_view, 6> kExternalNames = {"E1", "E2", "E3", "E4", "E5", "E6"};
constexpr int kDefaultAdvance = 3;
constexpr int kFullPercent = 100;

std::optional<double> component_of(const Value& value, const Structure& structure, std::string_view field) {
  const auto at = structure.find(field);
  const auto* parts = std::get_if<Parts>(&value);
  if (!at || !parts) return std::nullopt;
  const Value& part = (*parts)[static_cast<std::size_t>(*at)];
  return is_set(part) ? std::optional{number_of(part)} : std::nullopt;
}

std::optional<int> whole(std::optional<double> number) {
  return number ? std::optional{static_cast<int>(*number)} : std::nullopt;
}

}  // namespace

AxisTarget Interpreter::axes_of(const Value& value, const Type& type) const {
  AxisTarget target;
  for (std::size_t i = 0; i < kAxisNames.size(); ++i)
    target.axes[i] = component_of(value, program_.types.structure(type), kAxisNames[i]);
  return target;
}

PoseTarget Interpreter::pose_of(const Value& value, const Type& type) const {
  const Structure& structure = program_.types.structure(type);
  PoseTarget target{.status = whole(component_of(value, structure, "S")),
                    .turn = whole(component_of(value, structure, "T"))};
  for (std::size_t i = 0; i < kPoseNames.size(); ++i) {
    target.pose[i] = component_of(value, structure, kPoseNames[i]);
    target.external[i] = component_of(value, structure, kExternalNames[i]);
  }
  return target;
}

void Interpreter::move(const MotionShape& shape) {
  if (kind_ == InterpreterKind::Submit) throw Fault{.what = "a submit program must not move the arm"};
  Motion motion{.kind = shape.kind, .approximation = shape.approximation};
  if (shape.has_angle) motion.circle_angle_deg = std::get<double>(evaluator_.pop());
  const Value target = evaluator_.pop();
  if (program_.types.structure(shape.target).find("A1")) {
    motion.target = axes_of(target, shape.target);
  } else {
    motion.target = pose_of(target, shape.target);
  }
  if (shape.kind == MotionKind::Circ) motion.via = pose_of(evaluator_.pop(), shape.via);
  take_variables(motion);

  if (const auto at = interrupt_frame()) {
    Interruption& interruption = *frames_[*at].interruption;
    if (!interruption.may_move) throw Fault{.what = "a motion in an interrupt program needs BRAKE before it"};
    if (!interruption.moves) {
      unfinished();
      interruption.moves = true;
      interruption.holds = false;
      interruption.parked = std::exchange(sent_, {});
      host_.cancel();
    } else if (std::exchange(interruption.holds, false)) {
      host_.go_on();
    }
  }
  hand_over(std::move(motion));
  const double advance = number("$ADVANCE", std::nullopt, "").value_or(kDefaultAdvance);
  const auto most = static_cast<std::size_t>(std::clamp(advance, 0.0, 5.0));
  if (unfinished() > most) wait_for({.what = WaitFor::Room, .most = most});
}

void Interpreter::hand_over(Motion motion) {
  motion.number = ++motions_;
  if (const auto taken = host_.move(motion); !taken) throw Fault{.what = taken.error()};
  sent_.push_back(std::move(motion));
}

std::size_t Interpreter::unfinished() {
  while (!sent_.empty() && host_.is_finished(sent_.front().number)) sent_.pop_front();
  return sent_.size();
}

std::size_t Interpreter::awaited() {
  const auto at = interrupt_frame();
  return at && !frames_[*at].interruption->moves ? 0 : unfinished();
}

std::optional<double> Interpreter::number(std::string_view variable, std::optional<int> index,
                                          std::string_view field) {
  const auto at = std::ranges::find(program_.systems, variable, &Variable::name);
  if (at == program_.systems.end()) return std::nullopt;
  const Value value = host_.read(variable, index);
  if (!has_type(value, index ? at->type.element() : at->type, program_.types) || !is_set(value))
    return std::nullopt;
  return field.empty() ? std::optional{number_of(value)}
                       : component_of(value, program_.types.structure(at->type), field);
}

std::optional<FrameValues> Interpreter::frame_values(std::string_view variable) {
  FrameValues values{};
  for (std::size_t i = 0; i < values.size(); ++i) {
    const auto component = number(variable, std::nullopt, kPoseNames[i]);
    if (!component) return std::nullopt;
    values[i] = *component;
  }
  return values;
}

void Interpreter::take_variables(Motion& motion) {
  motion.tool = frame_values("$TOOL");
  motion.base = frame_values("$BASE");
  for (std::size_t i = 0; i < motion.velocity_percent.size(); ++i) {
    const int axis = static_cast<int>(i) + 1;
    motion.velocity_percent[i] = whole(number("$VEL_AXIS", axis, "")).value_or(kFullPercent);
    motion.acceleration_percent[i] = whole(number("$ACC_AXIS", axis, "")).value_or(kFullPercent);
  }
  motion.path_velocity_m_s = number("$VEL", std::nullopt, "CP");
  motion.path_acceleration_m_s2 = number("$ACC", std::nullopt, "CP");
  motion.approximation_distance_mm = number("$APO", std::nullopt, "CDIS");
  motion.approximation_percent = whole(number("$APO", std::nullopt, "CPTP"));
}

}  // namespace truepose::sim::krl
