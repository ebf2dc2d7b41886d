#include "core/quality/joint_limits.hpp"

#include <algorithm>
#include <limits>
#include <string>

#include "core/arm/joint_units.hpp"
#include "core/formatted.hpp"

namespace truepose {
namespace {

constexpr double kBesideStop = 0.1;  // deg, mm

/// "joint 1 from -148.2 to 149.6 deg (limits -20 and 20)", or nothing within the limits.
std::string beyond_limits(int i, const Joint& joint, std::span<const Measurement> points) {
  double min = std::numeric_limits<double>::infinity(), max = -min;
  for (const Measurement& point : points) {
    min = std::min(min, point.q[i]);
    max = std::max(max, point.q[i]);
  }
  const double unit = unit_of(joint);
  if (min >= joint.min - kBesideStop * unit && max <= joint.max + kBesideStop * unit) return {};
  return formatted("joint %d from %.1f to %.1f %s (limits %.6g and %.6g)", i + 1, min / unit, max / unit,
                   unit_name(joint).data(), joint.min / unit, joint.max / unit);
}

}  // namespace

std::optional<Finding> measured_beyond_limits(const RobotModel& nominal,
                                              std::span<const Measurement> points) {
  std::string beyond;
  for (int i = 0; i < nominal.joint_count(); ++i) {
    const std::string joint = beyond_limits(i, nominal.joints[static_cast<std::size_t>(i)], points);
    if (!joint.empty()) beyond += (beyond.empty() ? "" : ", ") + joint;
  }
  if (beyond.empty()) return std::nullopt;
  return finding(FindingKind::BeyondLimits,
                 "measured beyond the limits of the robot file: " + beyond +
                     "; the uncertainty of unmeasured poses holds within these limits alone");
}

}  // namespace truepose
