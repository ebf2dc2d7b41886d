#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <expected>
#include <span>
#include <string>

namespace truepose {

/// The rigid motion X that brings `from` nearest to `to` in the least squares of |X from_i - to_i|.
///
/// Errors: fewer than three points, or all of them on one line, whose turn about it nothing shows.
/// Source: Umeyama, Least-squares estimation of transformation parameters, IEEE PAMI 13 (1991).
std::expected<Eigen::Isometry3d, std::string> rigid_fit(std::span<const Eigen::Vector3d> from,
                                                        std::span<const Eigen::Vector3d> to);

}  // namespace truepose
