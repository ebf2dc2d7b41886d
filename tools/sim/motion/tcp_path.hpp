#pragma once

#include <Eigen/Geometry>
#include <expected>
#include <optional>
#include <string>
#include <vector>

namespace truepose::sim {

/// A piece of the TCP's path in the base: a line, an arc or a curve, along which the orientation turns evenly
/// about one axis. mm, rad.
class TcpPath {
 public:
  static TcpPath line(const Eigen::Isometry3d& from, const Eigen::Isometry3d& to);
  /// The circle through three points; a line where they are in one.
  static TcpPath arc(const Eigen::Isometry3d& from, const Eigen::Vector3d& via, const Eigen::Isometry3d& to);
  /// The same circle, but through `angle_rad` of it, below 0 the other way round; the orientation of `to` is
  /// reached at its end. Errors: the points are in one line.
  static std::expected<TcpPath, std::string> arc(const Eigen::Isometry3d& from, const Eigen::Vector3d& via,
                                                 const Eigen::Isometry3d& to, double angle_rad);
  /// @param leaving, arriving  directions there, of length 1
  static TcpPath curve(const Eigen::Isometry3d& from, const Eigen::Isometry3d& to,
                       const Eigen::Vector3d& leaving, const Eigen::Vector3d& arriving);

  /// What its speed counts by: its length, or more where the TCP turns much on it.
  double length_mm() const;
  /// @param share  of the way, 0..1
  Eigen::Isometry3d at(double share) const;
  /// Directions at its ends, of length 1; 0 where the TCP stays on its place.
  Eigen::Vector3d leaving() const { return direction(0, 1); }
  Eigen::Vector3d arriving() const { return direction(1, -1); }

 private:
  TcpPath(const Eigen::Isometry3d& from, const Eigen::Isometry3d& to);
  Eigen::Vector3d position(double share) const;
  Eigen::Vector3d direction(double share, double into) const;
  Eigen::Vector3d on_curve(double u) const;
  bool bend(const Eigen::Vector3d& via);

  Eigen::Isometry3d from_;
  Eigen::Vector3d to_;
  Eigen::Vector3d turn_;
  Eigen::Vector3d centre_{0, 0, 0}, arm_{0, 0, 0}, axis_{0, 0, 1};
  double angle_ = 0;                                      // of an arc
  Eigen::Vector3d leaving_{0, 0, 0}, arriving_{0, 0, 0};  // of a curve
  std::vector<double> covered_mm_;                        // of a curve, up to the points of its table
};

/// How a segment of a spline block comes to its end.
struct SplineSegment {
  enum class Kind { Line, Arc, Curve };
  Kind kind = Kind::Curve;
  Eigen::Isometry3d to;
  std::optional<Eigen::Vector3d> via = {};  ///< of an arc
  std::optional<double> angle_rad = {};
};

/// The pieces of a spline block. Curves go through all points without a corner, and into lines and arcs
/// along their direction; only where lines and arcs meet there may be one.
/// Errors: why a segment cannot be made.
std::expected<std::vector<TcpPath>, std::string> spline_path(const Eigen::Isometry3d& from,
                                                             const std::vector<SplineSegment>& segments);

}  // namespace truepose::sim
