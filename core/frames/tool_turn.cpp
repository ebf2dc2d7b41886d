#include "core/frames/tool_turn.hpp"

#include <algorithm>
#include <cmath>

#include "core/fit/measurement_model.hpp"
#include "core/fit/target_turns.hpp"

namespace truepose {

bool is_turned(const FrameReadings& data) {
  return std::ranges::any_of(data.readings,
                             [](const FrameReading& reading) { return reading.orientation.has_value(); });
}

FrameReadings without_orientations(FrameReadings data) {
  for (FrameReading& reading : data.readings) reading.orientation.reset();
  return data;
}

std::expected<ToolTurn, std::string> tool_turn(const FrameReadings& data, const MeasuringCell& by) {
  std::vector<Measurement> points;
  std::vector<double> share;  // of the mean
  double weights = 0;
  for (const FrameReading& reading : data.readings) {
    points.push_back({.q = reading.q, .orientation = reading.orientation});
    weights += share.emplace_back(1 / std::pow(reading.orientation->sigma_rad, 2));
  }
  for (double& of_reading : share) of_reading /= weights;

  const auto mounted = best_mountings(by.cell, points);
  ToolTurn result{.R_FT = mounted.front().value()};
  double square_sum = 0;
  for (const Eigen::Vector3d& turn : target_turns(by.cell, points, mounted)) {
    square_sum += weights * share[result.error_rad.size()] * turn.squaredNorm();
    result.error_rad.push_back(turn.norm());
  }
  if (std::string why = reason_not_an_arm(result.error_rad); !why.empty()) return std::unexpected(why);

  result.by_parameters.setZero(3, ParameterLayout::of(by.cell).size());
  const double spare = 3 * static_cast<double>(points.size() - 1);
  for (std::size_t i = 0; i < points.size(); ++i) {
    // Where the flange turns on, the same reading leaves the tool behind by as much.
    PointJacobian J;
    const Eigen::Matrix3d R_WF = turn_with_jacobian(by.cell, points[i].q, J);
    result.by_parameters -= share[i] * (R_WF.transpose() * J);
    const double alone =
        spare > 0 ? weights * share[i] * std::pow(result.error_rad[i], 2) / (1 - share[i]) : 0;
    const double others = spare > 3 ? (square_sum - alone) / (spare - 3) : 0;
    result.sigmas.push_back(std::sqrt(alone / std::max(1.0, others)));
  }
  const double sigma0 = spare > 0 ? std::sqrt(square_sum / spare) : 0;
  result.sigma_rad = std::max(1.0, sigma0) / std::sqrt(weights);
  return result;
}

}  // namespace truepose
