#pragma once

#include <Eigen/Core>
#include <span>

#include "core/data/calibrated_cell.hpp"

namespace truepose {

/// Derivative of the positions of a cell's first reflector to its parameters (order of ParameterLayout), pose
/// by pose: 3 rows each, mm per mm or rad.
Eigen::MatrixXd position_jacobian(const CalibratedCell& cell, std::span<const JointVector> poses);

/// A basis B of the directions that the rows of J can tell, in which they are known alike: the columns of
/// J B are orthonormal. As many columns as the rank. Columns of J are scaled before the rank is judged.
Eigen::MatrixXd whitened_basis(const Eigen::MatrixXd& J);

/// The smallest root mean square (mm, of the length of the error) that any unbiased fit can have at other
/// poses: the pseudo-inverse of the information of the measured ones, carried to these.
///
/// @param truth     the cell as it is
/// @param measured  poses that identify
/// @param elsewhere poses that are predicted; what they need and the measured ones do not tell is left out
/// @param sigma_mm  of each measured coordinate, independent
/// Source: Cramer, Mathematical Methods of Statistics (1946), ch. 32; Rao (1945).
double cramer_rao_rms_mm(const CalibratedCell& truth, std::span<const JointVector> measured,
                         std::span<const JointVector> elsewhere, double sigma_mm);

}  // namespace truepose
