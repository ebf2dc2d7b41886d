#include "core/frames/frame_of_points.hpp"

#include <algorithm>
#include <cmath>

#include "core/formatted.hpp"
#include "core/math/angles.hpp"
#include "core/math/rigid_fit.hpp"

namespace truepose {
namespace {

using Places = std::vector<Eigen::Vector3d>;
using FramePose = std::expected<Eigen::Isometry3d, std::string>;

constexpr double kLeastLeg_mm = 1;
constexpr double kLeastAngle_rad = 5 * kRadPerDeg;
constexpr double kSameShape_mm = 1;     // further off, points are swapped rather than badly made
constexpr double kPointStep_mm = 1e-3;  // of the derivative

const Eigen::Vector3d* place_of(std::span<const FramePoint> points, const Places& p_mm, const char* name) {
  const auto found = std::ranges::find(points, name, &FramePoint::name);
  return found == points.end() ? nullptr : &p_mm[static_cast<std::size_t>(found - points.begin())];
}

FramePose by_three(const Eigen::Vector3d& origin, const Eigen::Vector3d& on_x, const Eigen::Vector3d& in_xy) {
  const Eigen::Vector3d x = on_x - origin, xy = in_xy - origin, z = x.cross(xy);
  const double legs = x.norm() * xy.norm();
  if (!(std::min(x.norm(), xy.norm()) >= kLeastLeg_mm) || !(z.norm() >= std::sin(kLeastAngle_rad) * legs))
    return std::unexpected(
        "origin, x and xy are nearly on one line or in one place and do not show the XY plane: measure "
        "them far apart");
  Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
  X.linear() << x.normalized(), z.cross(x).normalized(), z.normalized();
  X.translation() = origin;
  return X;
}

Places known_points(std::span<const FramePoint> points) {
  Places known;
  for (const FramePoint& point : points) {
    if (point.p_mm) known.push_back(*point.p_mm);
  }
  return known;
}

FramePose pose_of(std::span<const FramePoint> points, const Places& p_mm,
                  const std::optional<Eigen::Matrix3d>& R_else) {
  const Places known = known_points(points);
  if (!known.empty() && known.size() == points.size()) return rigid_fit(known, p_mm);
  const auto *origin = place_of(points, p_mm, kOrigin), *on_x = place_of(points, p_mm, kOnX),
             *in_xy = place_of(points, p_mm, kInXy);
  if (known.empty() && points.size() == 3 && origin && on_x && in_xy) return by_three(*origin, *on_x, *in_xy);
  if (known.empty() && points.size() == 1 && origin && R_else) {
    Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
    X.linear() = *R_else;
    X.translation() = *origin;
    return X;
  }
  return std::unexpected(std::string("the points say no frame: expected ") +
                         (R_else ? "the origin alone, or " : "") +
                         "origin, x and xy, or at least three points that all have known coordinates");
}

}  // namespace

std::expected<FrameOfPoints, std::string> frame_of_points(std::span<const FramePoint> points,
                                                          std::span<const Eigen::Vector3d> p_mm,
                                                          const std::optional<Eigen::Matrix3d>& R_else) {
  Places p(p_mm.begin(), p_mm.end());
  const FramePose X = pose_of(points, p, R_else);
  if (!X) return std::unexpected(X.error());
  FrameOfPoints frame{.X = *X};
  frame.is_orientation_known = points.size() > 1;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (points[i].p_mm) frame.misfit_mm.push_back((*X * *points[i].p_mm - p[i]).norm());
  }
  const auto worst = std::ranges::max_element(frame.misfit_mm);
  if (worst != frame.misfit_mm.end() && *worst > kSameShape_mm) {
    const std::string& name = points[static_cast<std::size_t>(worst - frame.misfit_mm.begin())].name;
    return std::unexpected("the points do not have the stated shape: " + name + " is " +
                           formatted("%.3f", *worst) +
                           " mm off; look for points that are swapped and for wrong coordinates");
  }

  frame.by_points.resize(6, 3 * static_cast<Eigen::Index>(p.size()));
  for (Eigen::Index k = 0; k < frame.by_points.cols(); ++k) {
    double& coordinate = p[static_cast<std::size_t>(k / 3)][k % 3];
    const double here = coordinate;
    const auto at = [&](double moved) {
      coordinate = moved;
      return pose_of(points, p, R_else).value_or(frame.X);
    };
    const Eigen::Isometry3d before = at(here - kPointStep_mm), after = at(here + kPointStep_mm);
    coordinate = here;
    frame.by_points.col(k) << after.translation() - before.translation(),
        turn_between(before.linear(), after.linear());
  }
  frame.by_points /= 2 * kPointStep_mm;
  return frame;
}

double variance_at(const PoseCovariance& covariance, const Eigen::Vector3d& from_origin_mm) {
  Eigen::Matrix<double, 3, 6> J;
  J.leftCols<3>().setIdentity();
  for (int axis = 0; axis < 3; ++axis) J.col(3 + axis) = Eigen::Vector3d::Unit(axis).cross(from_origin_mm);
  return (J * covariance * J.transpose()).trace();
}

}  // namespace truepose
