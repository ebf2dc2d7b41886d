#include "proto/record/transfer.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <utility>
#include <vector>

#include "core/arm/joint_units.hpp"

namespace truepose::record {
namespace {

/// Enough to see where it gets worse, and few enough for the io thread and for a stored document.
constexpr int kSamples = 17;

const Joint& joint_of(const Calibration& calibration, int joint) {
  return calibration.cell.robot.joints[static_cast<std::size_t>(joint)];
}

/// Positions of one joint over the poses that identified, ascending.
std::vector<double> measured(const MeasurementData& data, int joint) {
  std::vector<double> positions;
  for (const Measurement& m : data.points) {
    if (m.set == PoseSet::Identify) positions.push_back(m.q[joint]);
  }
  std::ranges::sort(positions);
  return positions;
}

/// The limits, of a revolute joint one turn at most: beyond it the arm stands as before.
std::pair<double, double> range_of(const Joint& joint) {
  if (joint.type == JointType::Prismatic) return {joint.min, joint.max};
  return {std::max(joint.min, -std::numbers::pi), std::min(joint.max, std::numbers::pi)};
}

/// "joint 2 was measured from -40 to 35 deg only, joint 5 ..." for the joints whose worst position lies
/// outside.
std::string not_measured(const Calibration& calibration, const MeasurementData& data) {
  std::vector<std::string> joints;
  for (int i = 0; i < calibration.cell.robot.joint_count(); ++i) {
    const std::vector<double> positions = measured(data, i);
    const double worst = calibration.transfer.worst[i];
    if (positions.front() <= worst && worst <= positions.back()) continue;
    const Joint& joint = joint_of(calibration, i);
    joints.push_back(fmt::format("joint {} was measured from {:.0f} to {:.0f} {} only", i + 1,
                                 positions.front() / unit_of(joint), positions.back() / unit_of(joint),
                                 unit_name(joint)));
  }
  return joints.empty() ? "no pose near them was measured" : fmt::format("{}", fmt::join(joints, ", "));
}

/// "10, -90, 0 deg", or with a prismatic joint "10 deg, 250 mm".
std::string worst_joints(const Calibration& calibration) {
  const std::vector<Joint>& joints = calibration.cell.robot.joints;
  const bool alike =
      std::ranges::all_of(joints, [](const Joint& j) { return j.type == JointType::Revolute; });
  std::vector<std::string> positions;
  for (std::size_t i = 0; i < joints.size(); ++i) {
    const double q = calibration.transfer.worst[static_cast<Eigen::Index>(i)];
    positions.push_back(fmt::format("{:.0f}{}{}", q / unit_of(joints[i]), alike ? "" : " ",
                                    alike ? "" : unit_name(joints[i])));
  }
  return fmt::format("{}{}", fmt::join(positions, ", "), alike ? " deg" : "");
}

/// To three digits, which is more than a standard deviation deserves.
double rounded(double value) {
  if (!(value > 0)) return 0;
  const double unit = std::pow(10.0, std::floor(std::log10(value)) - 2);
  return unit < 1 ? std::round(value / unit) / std::round(1 / unit) : std::round(value / unit) * unit;
}

double sample(std::pair<double, double> range, int k) {
  return range.first + k * (range.second - range.first) / (kSamples - 1);
}

Sweep sweep_of(const Calibration& calibration, int joint) {
  const Joint& j = joint_of(calibration, joint);
  const auto [from, to] = range_of(j);
  return {joint + 1, from / unit_of(j), to / unit_of(j), kSamples};
}

UncertaintyMap map_of(const Calibration& calibration, const JointVector& held, int x, int y) {
  const auto range_x = range_of(joint_of(calibration, x)), range_y = range_of(joint_of(calibration, y));
  UncertaintyMap map{
      sweep_of(calibration, x), sweep_of(calibration, y), in_deg_mm(held, calibration.cell.robot), {}};
  JointVector q = held;
  for (int row = 0; row < kSamples; ++row) {
    std::vector<double>& sigmas = map.sigma_mm.emplace_back();
    q[y] = sample(range_y, row);
    for (int column = 0; column < kSamples; ++column) {
      q[x] = sample(range_x, column);
      sigmas.push_back(rounded(std::sqrt(calibration.position_covariance(q, 0).trace())));
    }
  }
  return map;
}

std::vector<UncertaintyMap> maps_of(const Calibration& calibration, const MeasurementData& data) {
  const int joints = calibration.cell.robot.joint_count();
  JointVector held(joints);
  for (int i = 0; i < joints; ++i) {
    const std::vector<double> positions = measured(data, i);
    held[i] = positions[positions.size() / 2];
  }
  std::vector<UncertaintyMap> maps;
  if (joints >= 3) maps.push_back(map_of(calibration, held, 1, 2));
  if (joints >= 2) maps.push_back(map_of(calibration, held, 0, 1));
  return maps;
}

}  // namespace

std::string transfer_warning(const Calibration& calibration, const MeasurementData& data) {
  const double nominal_mm = calibration.identify.before.mean, worst_mm = calibration.transfer.max_mm;
  if (!(worst_mm > nominal_mm)) return {};
  return fmt::format(
      "Measure poses towards the joints {}: {}, and there the position is predicted with a standard "
      "deviation of {:.3g} mm, more than the nominal arm's mean error of {:.3g} mm.",
      worst_joints(calibration), not_measured(calibration, data), worst_mm, nominal_mm);
}

Transfer transfer_of(const Calibration& calibration, const MeasurementData& data) {
  return {.rms_mm = calibration.transfer.rms_mm,
          .max_mm = calibration.transfer.max_mm,
          .worst_joints = in_deg_mm(calibration.transfer.worst, calibration.cell.robot),
          .warning = transfer_warning(calibration, data),
          .maps = maps_of(calibration, data)};
}

}  // namespace truepose::record
