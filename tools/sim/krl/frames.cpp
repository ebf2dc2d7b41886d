#include "tools/sim/krl/frames.hpp"

#include <array>
#include <cmath>
#include <numbers>

#include "tools/sim/krl/fault.hpp"
#include "tools/sim/krl/operations.hpp"

namespace truepose::sim::krl {
namespace {

constexpr std::array<const char*, 6> kPoseFields = {"X", "Y", "Z", "A", "B", "C"};
constexpr double kDegreesPerRadian = 180 / std::numbers::pi;

struct Transform {
  std::array<std::array<double, 3>, 3> rotation = {};
  std::array<double, 3> translation = {};
};

std::size_t field_of(const char* field, const Type& type, const Types& types) {
  return static_cast<std::size_t>(*types.structure(type).find(field));
}

Transform transform_of(const Value& value, const Type& type, const Types& types) {
  const Parts& parts = std::get<Parts>(value);
  std::array<double, 6> pose{};
  for (std::size_t i = 0; i < pose.size(); ++i) {
    const Value& part = parts[field_of(kPoseFields[i], type, types)];
    if (!is_set(part)) throw Fault{.what = std::string("the component ") + kPoseFields[i] + " has no value"};
    pose[i] = number_of(part);
  }
  const double a = pose[3] / kDegreesPerRadian, b = pose[4] / kDegreesPerRadian,
               c = pose[5] / kDegreesPerRadian;
  const double ca = std::cos(a), sa = std::sin(a), cb = std::cos(b), sb = std::sin(b), cc = std::cos(c),
               sc = std::sin(c);
  return {{{{ca * cb, ca * sb * sc - sa * cc, ca * sb * cc + sa * sc},
            {sa * cb, sa * sb * sc + ca * cc, sa * sb * cc - ca * sc},
            {-sb, cb * sc, cb * cc}}},
          {pose[0], pose[1], pose[2]}};
}

Transform product(const Transform& left, const Transform& right) {
  Transform result{.translation = left.translation};
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t k = 0; k < 3; ++k) {
      result.translation[i] += left.rotation[i][k] * right.translation[k];
      for (std::size_t j = 0; j < 3; ++j) result.rotation[i][j] += left.rotation[i][k] * right.rotation[k][j];
    }
  }
  return result;
}

Transform inverted(const Transform& transform) {
  Transform result;
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) {
      result.rotation[i][j] = transform.rotation[j][i];
      result.translation[i] -= transform.rotation[j][i] * transform.translation[j];
    }
  }
  return result;
}

/// A, B, C in deg. At B = 90 deg only A - C matters: C is 0 there.
std::array<double, 3> angles_of(const std::array<std::array<double, 3>, 3>& r) {
  const double cos_b = std::hypot(r[0][0], r[1][0]);
  const double b = std::atan2(-r[2][0], cos_b);
  constexpr double kGimbalLock = 1e-9;
  const double a = cos_b > kGimbalLock ? std::atan2(r[1][0], r[0][0]) : std::atan2(-r[0][1], r[1][1]);
  const double c = cos_b > kGimbalLock ? std::atan2(r[2][1], r[2][2]) : 0;
  return {a * kDegreesPerRadian, b * kDegreesPerRadian, c * kDegreesPerRadian};
}

Value with_pose(Value value, const Transform& transform, const Type& type, const Types& types) {
  Parts& parts = std::get<Parts>(value);
  const std::array<double, 3> angles = angles_of(transform.rotation);
  for (std::size_t i = 0; i < 3; ++i) {
    parts[field_of(kPoseFields[i], type, types)] = to_real(transform.translation[i]);
    parts[field_of(kPoseFields[i + 3], type, types)] = to_real(angles[i]);
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
  const Transform pose =
      product(transform_of(left, left_type, types), transform_of(right, right_type, types));
  return with_pose(right, pose, right_type, types);
}

Value inverse_of(const Value& value, const Type& type, const Types& types) {
  return with_pose(value, inverted(transform_of(value, type, types)), type, types);
}

}  // namespace truepose::sim::krl
