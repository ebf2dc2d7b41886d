#include "tools/sim/krl/frames.hpp"

#include "core/math/angles.hpp"
#include "proto/text/kuka_names.hpp"
#include "tools/sim/krl/fault.hpp"
#include "tools/sim/krl/operations.hpp"

namespace truepose::sim::krl {
namespace {

std::size_t field_of(std::string_view field, const Type& type, const Types& types) {
  return static_cast<std::size_t>(*types.structure(type).find(field));
}

Eigen::Isometry3d transform_of(const Value& value, const Type& type, const Types& types) {
  const Parts& parts = std::get<Parts>(value);
  std::array<double, 6> pose{};
  for (std::size_t i = 0; i < pose.size(); ++i) {
    const Value& part = parts[field_of(kPoseNames[i], type, types)];
    if (!is_set(part)) throw Fault{.what = "the component " + std::string(kPoseNames[i]) + " has no value"};
    pose[i] = number_of(part);
  }
  return pose_from_kuka({pose[0], pose[1], pose[2]}, {pose[3], pose[4], pose[5]});
}

Value with_pose(Value value, const Eigen::Isometry3d& X, const Type& type, const Types& types) {
  Parts& parts = std::get<Parts>(value);
  const Eigen::Vector3d translation = X.translation(), angles = kuka_abc_deg(X.linear());
  for (std::size_t i = 0; i < kPoseNames.size(); ++i) {
    const auto axis = static_cast<Eigen::Index>(i % 3);
    parts[field_of(kPoseNames[i], type, types)] = to_real(i < 3 ? translation[axis] : angles[axis]);
  }
  return value;
}

}  // namespace

Value reshaped(const Value& value, const Type& from, const Type& to, const Types& types) {
  const auto& fields = types.structure(to).fields;
  Parts parts(fields.size());
  for (std::size_t i = 0; i < fields.size(); ++i) {
    if (const auto at = types.structure(from).find(fields[i].name))
      parts[i] = std::get<Parts>(value)[static_cast<std::size_t>(*at)];
  }
  return parts;
}

Value composed(const Value& left, const Type& left_type, const Value& right, const Type& right_type,
               const Types& types) {
  const Eigen::Isometry3d X = transform_of(left, left_type, types) * transform_of(right, right_type, types);
  return with_pose(right, X, right_type, types);
}

Value inverse_of(const Value& value, const Type& type, const Types& types) {
  return with_pose(value, truepose::inverse_of(transform_of(value, type, types)), type, types);
}

}  // namespace truepose::sim::krl
