#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "core/data/calibrated_cell.hpp"
#include "core/data/measurement.hpp"

namespace truepose {

/// How an arm changes with the temperatures of its drives. The geometric model that goes with it is the arm
/// with all drives at their reference.
struct ThermalResponse {
  std::vector<double> reference_c;  ///< of each joint's drive
  /// What becomes of each joint's zero (rad or mm, in the sense of q) per kelvin of its own drive, and last
  /// of all lengths (share) per kelvin of the mean of all drives.
  Eigen::VectorXd per_kelvin;
  /// Covariance of per_kelvin with the parameters of the model (ParameterLayout), then with itself: a row for
  /// each number.
  Eigen::MatrixXd covariance;

  Eigen::Index size() const { return per_kelvin.size(); }
  Eigen::Index parameters() const { return covariance.cols() - size(); }
};

/// How per_kelvin moves the parameters of a cell with its drives so warm: a column for each number.
Eigen::MatrixXd thermal_directions(const CalibratedCell& cell, const ThermalResponse& response,
                                   std::span<const double> temperature_c);

/// The arm with its drives so warm.
///
/// @param temperature_c  one a joint
RobotModel at_temperatures(RobotModel robot, const ThermalResponse& response,
                           std::span<const double> temperature_c);

/// Covariance of the parameters of the arm with its drives so warm.
///
/// @param covariance  of those of `cell`, which is at the reference
Eigen::MatrixXd covariance_at_temperatures(const CalibratedCell& cell, const Eigen::MatrixXd& covariance,
                                           const ThermalResponse& response,
                                           std::span<const double> temperature_c);

/// The same response for the geometric model at these temperatures of the drives.
///
/// @param cell  at the reference
ThermalResponse with_reference(ThermalResponse response, const CalibratedCell& cell,
                               std::span<const double> temperature_c);

/// The points where they would have been with all drives at the reference. Points without temperatures stay.
MeasurementData at_reference(MeasurementData data, const CalibratedCell& cell,
                             const ThermalResponse& response);

/// The mean over the points that tell temperatures of each drive's; empty where none does.
std::vector<double> mean_temperatures_c(std::span<const Measurement> points);

}  // namespace truepose
