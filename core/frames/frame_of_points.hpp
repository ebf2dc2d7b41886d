#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <expected>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace truepose {

/// What a frame is measured by: its origin, "x" anywhere on its +X axis and "xy" anywhere in its XY plane on
/// the side of +Y, or points whose coordinates in it are known.
struct FramePoint {
  std::string name;
  std::optional<Eigen::Vector3d> p_mm;  ///< in the frame that is measured, where known
};

inline constexpr const char* kOrigin = "origin";
inline constexpr const char* kOnX = "x";
inline constexpr const char* kInXy = "xy";

/// Covariance of a pose: three of its position (mm), three of a small turn (rad) about the outer axes.
using PoseCovariance = Eigen::Matrix<double, 6, 6>;

/// Variance (mm^2) of where a frame has a point that is so far from its origin, along the outer axes.
double variance_at(const PoseCovariance& covariance, const Eigen::Vector3d& from_origin_mm);

struct FrameOfPoints {
  Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
  Eigen::Matrix<double, 6, Eigen::Dynamic> by_points;  ///< derivative to the points' coordinates
  std::vector<double> misfit_mm;     ///< of each point whose coordinates are known; empty where none are
  bool is_orientation_known = true;  ///< false: taken from `R_else`, for there is an origin alone
};

/// The frame in whose coordinates the points are what they should be: by origin, x and xy, or where all
/// coordinates are known the nearest in least squares.
///
/// @param p_mm    of each point, in the outer frame
/// @param R_else  orientation of a frame of which the origin alone was measured; none: that is an error
/// Errors: points that say no frame, lie on one line, or do not have the shape that is stated.
std::expected<FrameOfPoints, std::string> frame_of_points(std::span<const FramePoint> points,
                                                          std::span<const Eigen::Vector3d> p_mm,
                                                          const std::optional<Eigen::Matrix3d>& R_else);

}  // namespace truepose
