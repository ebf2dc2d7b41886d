#pragma once

#include <Eigen/Geometry>
#include <array>

#include "proto/krl/program.hpp"

namespace truepose::krl {

/// X, Y, Z in mm, A, B, C in deg.
Eigen::Isometry3d pose_of_numbers(const std::array<double, 6>& numbers);
std::array<double, 6> numbers_of_pose(const Eigen::Isometry3d& X);

/// All six, 0 for those that are not given.
std::array<double, 6> numbers_of(const Offset& offset);

/// The TCP's pose in the base that a motion leads to. Not of axes.
/// @param from   the TCP's pose where the arm comes from; of Base and Tool
/// @param point  of the point that it is computed from; of Behind and Before
Eigen::Isometry3d target_of(const Offset& offset, const Eigen::Isometry3d& from,
                            const Eigen::Isometry3d& point);

/// The numbers by which it leads to another target: target_of() the other way round.
std::array<double, 6> offset_to(const Offset& offset, const Eigen::Isometry3d& from,
                                const Eigen::Isometry3d& point, const Eigen::Isometry3d& target);

}  // namespace truepose::krl
