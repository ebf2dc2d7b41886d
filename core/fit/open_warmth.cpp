#include "core/fit/open_warmth.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/arm/forward.hpp"

namespace truepose {
namespace {

/// How warm the arm was at the points to identify: 0 cold, 1 warm through.
struct WarmthSeen {
  double mean = 0, variance = 0, least = 0, most = 0;
};

WarmthSeen warmth_seen(const MeasurementData& data) {
  std::vector<double> warmth;
  for (const Measurement& point : data.points)
    if (point.set == PoseSet::Identify && !point.temperature_c.empty())
      warmth.push_back(point.temperature_c.front());
  if (warmth.empty()) return {};
  WarmthSeen seen{.least = std::ranges::min(warmth), .most = std::ranges::max(warmth)};
  const auto count = static_cast<double>(warmth.size());
  for (const double each : warmth) seen.mean += each / count;
  for (const double each : warmth) seen.variance += std::pow(each - seen.mean, 2) / count;
  return seen;
}

/// One reading: how far the arm at the reference is from it, and how far warmth moves it from cold to warm
/// through. Frame of its station, mm.
struct OpenReading {
  std::size_t point = 0;
  Eigen::Vector3d predicted, off, by_warmth;
};

OpenReading open_reading(const MeasurementData& data, std::size_t point, const CalibratedCell& cell,
                         const ThermalResponse& response) {
  const Measurement& m = data.points[point];
  std::vector<double> warmer = response.reference_c;
  for (double& drive : warmer) drive += 1;
  const Eigen::Vector3d& p_FS_mm = cell.reflectors[static_cast<std::size_t>(m.smr)].p_FS_mm;
  const auto seen_at = [&](RobotModel robot) {
    LoadedArm arm(robot);
    return Eigen::Vector3d{cell.base_at(m.station).isometry() *
                           (forward_kinematics(arm.at(m), m.q, m.direction) * p_FS_mm)};
  };
  const Eigen::Vector3d predicted = seen_at(cell.robot);
  return {.point = point,
          .predicted = predicted,
          .off = m.p_WS_mm - predicted,
          .by_warmth = seen_at(at_temperatures(cell.robot, response, warmer)) - predicted};
}

/// Moves the readings of one pose.
void bring_to_reference(std::span<const OpenReading> pose, const WarmthSeen& seen, double reference,
                        double sigma_mm, MeasurementData& data) {
  double along = 0, squares = 0;
  for (const OpenReading& reading : pose) {
    along += reading.by_warmth.dot(reading.off + reference * reading.by_warmth);
    squares += reading.by_warmth.squaredNorm();
  }
  // A posteriori, of a warmth that is normally distributed; without any scatter its mean.
  const double noise2 = sigma_mm * sigma_mm,
               taken = squares * seen.variance / (noise2 + squares * seen.variance);
  if (!std::isfinite(taken) || squares <= 0) return;
  const double warmth = std::clamp(seen.mean + taken * (along / squares - seen.mean), seen.least, seen.most);
  const auto equations = 3 * static_cast<double>(pose.size());
  const double enlarged = std::sqrt(equations / (equations - taken));
  for (const OpenReading& reading : pose)
    data.points[reading.point].p_WS_mm =
        reading.predicted + enlarged * (reading.off - (warmth - reference) * reading.by_warmth);
}

}  // namespace

bool warmth_is_open(const Measurement& point) {
  return point.set == PoseSet::Validate && point.temperature_c.empty();
}

MeasurementData with_open_warmth(MeasurementData data, const CalibratedCell& cell,
                                 const ThermalResponse& response, double sigma_mm) {
  const WarmthSeen seen = warmth_seen(data);
  for (const std::vector<std::size_t>& group : pose_groups(data.points)) {
    std::vector<OpenReading> pose;
    for (const std::size_t i : group)
      if (warmth_is_open(data.points[i])) pose.push_back(open_reading(data, i, cell, response));
    if (!pose.empty()) bring_to_reference(pose, seen, response.reference_c.front(), sigma_mm, data);
  }
  return data;
}

}  // namespace truepose
