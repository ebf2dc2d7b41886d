// The part of Interpreter that hands motions to the host.
#include <algorithm>
#include <ranges>
#include <span>
#include <utility>

#include "proto/text/kuka_names.hpp"
#include "tools/sim/krl/interpreter.hpp"

namespace truepose::sim::krl {
namespace {

constexpr SixNames kExternalNames{"E1", "E2", "E3", "E4", "E5", "E6"};
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
  for (std::size_t i = 0; i < target.axes.size(); ++i)
    target.axes[i] =
        component_of(value, program_.types.structure(type), i < 6 ? kAxisNames[i] : kExternalNames[i - 6]);
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
  Motion motion = popped(shape);
  motion.switching = std::exchange(switching_, {});
  make_room_in_interrupt();
  hand_over(std::move(motion));
  const double advance = number("$ADVANCE", std::nullopt, "").value_or(kDefaultAdvance);
  const auto most = static_cast<std::size_t>(std::clamp(advance, 0.0, 5.0));
  if (unfinished() > most) wait_for({.what = WaitFor::Room, .most = most});
}

/// What stands on the stack, the last first.
Motion Interpreter::popped(const MotionShape& shape) {
  const std::size_t around = settings_.size();
  Motion motion{.kind = shape.kind, .approximation = shape.approximation, .is_in_tool = shape.is_in_tool};
  if (shape.ends_time) motion.time_s = number_of(evaluator_.pop());
  if (shape.ends_part) motion.time_percent = number_of(evaluator_.pop());
  pop_settings(shape.settings);
  take_variables(motion);
  if (shape.segments.empty()) pop_target(shape, motion);
  for (const MotionShape& segment : shape.segments | std::views::reverse)
    motion.segments.push_back(popped(segment));
  std::ranges::reverse(motion.segments);
  for (const TriggerShape& trigger : shape.triggers | std::views::reverse)
    motion.switching.push_back(pop_switching_point(trigger));
  settings_.resize(around);
  return motion;
}

void Interpreter::pop_target(const MotionShape& shape, Motion& motion) {
  if (shape.has_angle) motion.circle_angle_deg = std::get<double>(evaluator_.pop());
  const Value target = evaluator_.pop();
  if (program_.types.structure(shape.target).find("A1")) {
    motion.target = axes_of(target, shape.target);
  } else {
    motion.target = pose_of(target, shape.target);
  }
  if (shape.kind == MotionKind::Circ) motion.via = pose_of(evaluator_.pop(), shape.via);
}

void Interpreter::pop_settings(std::size_t count) {
  const std::size_t first = settings_.size();
  for (std::size_t i = 0; i < count; ++i) {
    Value value = evaluator_.pop();
    Place place = evaluator_.pop_place();
    static_cast<void>(evaluator_.look(place));  // finds an index outside of its array
    settings_.push_back({std::move(place), std::move(value)});
  }
  std::reverse(settings_.begin() + static_cast<std::ptrdiff_t>(first), settings_.end());
}

void Interpreter::make_room_in_interrupt() {
  const auto at = interrupt_frame();
  if (!at) return;
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
  const auto slot = program_.find_system(variable);
  if (!slot) return std::nullopt;
  const Value value = in_effect(*slot, index);
  const Variable& declared = program_.systems[*slot];
  const Type& type = index ? declared.element : declared.type;
  if (!has_type(value, type, program_.types) || !is_set(value)) return std::nullopt;
  return field.empty() ? std::optional{number_of(value)}
                       : component_of(value, program_.types.structure(type), field);
}

/// Of a system variable, or of one element: what WITH sets before what the controller has.
Value Interpreter::in_effect(std::size_t variable, std::optional<int> index) const {
  const Variable& declared = program_.systems[variable];
  Value value = host_.read(declared, index);
  for (const Setting& setting : settings_) {
    std::span<const std::int64_t> path = setting.place.path;
    if (setting.place.slot != variable || (index && path[0] != *index - 1)) continue;
    if (index) path = path.subspan(1);
    if (!is_set(value)) value = program_.types.blank(index ? declared.element : declared.type);
    set_part(value, path, setting.value);
  }
  return value;
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
  if (const auto mode = program_.find_system("$IPO_MODE"))
    motion.is_tool_fixed = in_effect(*mode, {}) == Value{Literal{"TCP"}};
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
