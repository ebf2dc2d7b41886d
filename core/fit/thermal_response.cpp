#include "core/fit/thermal_response.hpp"

#include <cassert>
#include <numeric>
#include <utility>

#include "core/arm/forward.hpp"
#include "core/math/dense_algebra.hpp"

namespace truepose {
namespace {

/// Kelvins above the reference: of each drive, then of their mean.
Eigen::VectorXd warmth(const ThermalResponse& response, std::span<const double> temperature_c) {
  const auto drives = static_cast<Eigen::Index>(temperature_c.size());
  assert(drives + 1 == response.size() && response.reference_c.size() == temperature_c.size());
  Eigen::VectorXd kelvins(drives + 1);
  kelvins.head(drives) = Eigen::VectorXd::Map(temperature_c.data(), drives) -
                         Eigen::VectorXd::Map(response.reference_c.data(), drives);
  kelvins[drives] = kelvins.head(drives).mean();
  return kelvins;
}

}  // namespace

Eigen::MatrixXd thermal_directions(const CalibratedCell& cell, const ThermalResponse& response,
                                   std::span<const double> temperature_c) {
  const ParameterLayout layout = ParameterLayout::of(cell);
  const Eigen::VectorXd kelvins = warmth(response, temperature_c);
  Eigen::MatrixXd D = Eigen::MatrixXd::Zero(layout.size(), kelvins.size());
  for (int i = 0; i < layout.joints; ++i) {
    constexpr int kA = 0, kD = 2;  // of ParameterLayout's five
    const Joint& joint = cell.robot.joints[static_cast<std::size_t>(i)];
    D(layout.link(i) + kA, layout.joints) = joint.a_mm * kelvins[layout.joints];
    D(layout.link(i) + kD, layout.joints) = joint.d_mm * kelvins[layout.joints];
    D(zero_parameter(cell.robot, layout, i), i) = joint.sign * kelvins[i];
  }
  return D;
}

RobotModel at_temperatures(RobotModel robot, const ThermalResponse& response,
                           std::span<const double> temperature_c) {
  CalibratedCell cell{.robot = std::move(robot), .base = {}, .reflectors = {}, .further_bases = {}};
  const Eigen::VectorXd step = thermal_directions(cell, response, temperature_c) * response.per_kelvin;
  move_by(cell, step);
  return std::move(cell.robot);
}

Eigen::MatrixXd covariance_at_temperatures(const CalibratedCell& cell, const Eigen::MatrixXd& covariance,
                                           const ThermalResponse& response,
                                           std::span<const double> temperature_c) {
  const Eigen::MatrixXd D = thermal_directions(cell, response, temperature_c);
  const Eigen::MatrixXd with_parameters = times(D, response.covariance.leftCols(response.parameters()));
  return covariance + with_parameters + with_parameters.transpose() +
         congruence(D, response.covariance.rightCols(response.size()));
}

ThermalResponse with_reference(ThermalResponse response, const CalibratedCell& cell,
                               std::span<const double> temperature_c) {
  const Eigen::MatrixXd D = thermal_directions(cell, response, temperature_c);
  response.covariance.leftCols(response.parameters()) +=
      times_transposed(response.covariance.rightCols(response.size()), D);
  response.reference_c.assign(temperature_c.begin(), temperature_c.end());
  return response;
}

MeasurementData at_reference(MeasurementData data, const CalibratedCell& cell,
                             const ThermalResponse& response) {
  for (Measurement& point : data.points) {
    if (point.temperature_c.empty()) continue;
    const RobotModel warm = at_temperatures(cell.robot, response, point.temperature_c);
    const Eigen::Vector3d& p_FS_mm = cell.reflectors[static_cast<std::size_t>(point.smr)].p_FS_mm;
    const Eigen::Vector3d moved_B_mm = forward_kinematics(warm, point.q, point.direction) * p_FS_mm -
                                       forward_kinematics(cell.robot, point.q, point.direction) * p_FS_mm;
    point.p_WS_mm -= cell.base_at(point.station).isometry().linear() * moved_B_mm;
  }
  return data;
}

std::vector<double> mean_temperatures_c(std::span<const Measurement> points) {
  std::vector<double> sum;
  double count = 0;
  for (const Measurement& point : points) {
    if (point.temperature_c.empty()) continue;
    sum.resize(point.temperature_c.size(), 0);
    for (std::size_t i = 0; i < sum.size(); ++i) sum[i] += point.temperature_c[i];
    ++count;
  }
  for (double& each : sum) each /= count;
  return sum;
}

}  // namespace truepose
