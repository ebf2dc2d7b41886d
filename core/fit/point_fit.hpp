#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>
#include <vector>

namespace truepose {

/// What one reading says of some points' coordinates u: A u = b, mm, to within its noise.
struct PointEquation {
  Eigen::Matrix<double, 3, Eigen::Dynamic> A;
  Eigen::Vector3d b;
  Eigen::Matrix3d covariance;  ///< of b, mm^2
};

/// The coordinates that such equations tell, by weighted least squares.
struct PointFit {
  Eigen::VectorXd u;             ///< mm
  Eigen::MatrixXd covariance;    ///< of u by the readings' noise, larger where they scatter more than that
  std::vector<double> error_mm;  ///< of each reading, from where all together say
  /// The same from where the others say, in standard deviations as they scatter, but of no less than the
  /// noise; 0 of a reading without which u were not known.
  std::vector<double> sigmas;
  /// How the readings scatter, in multiples of their noise; none where no reading is spare.
  std::optional<double> sigma0;
};

/// @param equations  that determine u
PointFit fit_points(std::span<const PointEquation> equations);

/// u alone.
Eigen::VectorXd solve_points(std::span<const PointEquation> equations);

}  // namespace truepose
