#include "core/arm/joint_axes.hpp"

#include <cmath>
#include <numbers>

#include "core/arm/forward.hpp"
#include "core/math/angles.hpp"
#include "core/math/rounding.hpp"

namespace truepose {
namespace {

using Eigen::Vector3d;

/// Shorter lengths (mm) and smaller angles (rad) are rounding of the source.
constexpr double kNoLength = 1e-9, kNoAngle = 1e-12;
/// Axes less inclined than this count as parallel: their common normal is far away or nowhere.
const double kParallel = std::sin(3 * kRadPerDeg);

struct Line {
  Vector3d point, direction;

  Vector3d foot_of(const Vector3d& p) const { return point + direction * direction.dot(p - point); }
};

/// The point of `line` that is next to the other, which is not parallel to it.
Vector3d nearest_to(const Line& line, const Line& other) {
  const double cos = line.direction.dot(other.direction);
  const Vector3d between = other.point - line.point;
  const double along = between.dot(line.direction) - cos * between.dot(other.direction);
  return line.point + line.direction * (along / (1 - cos * cos));
}

Vector3d square_to(const Vector3d& v, const Vector3d& z) { return v - z * z.dot(v); }

double angle_without_rounding(double rad) { return without_rounding(rad * kDegPerRad) * kRadPerDeg; }

/// Beta with an x axis (cos beta, 0, -sin beta) that is square to the line. Where the line's direction is
/// along y it says little, and the line's foot, which lies on that axis, says it.
double beta_to(const Vector3d& foot, const Vector3d& direction) {
  const double in_plane = std::hypot(direction.x(), direction.z());
  double beta = 0;
  if (in_plane < 0.5 && foot.norm() > kNoLength) {
    if (std::abs(foot.z()) > kNoLength) beta = std::atan2(-foot.z(), foot.x());
  } else if (std::abs(direction.x()) > kNoAngle) {
    beta = std::atan2(direction.x(), direction.z());
  }
  return std::abs(beta) > std::numbers::pi / 2 + kNoAngle ? beta - std::copysign(std::numbers::pi, beta)
                                                          : beta;
}

/// Beta, alpha and a that lead from frame X to a line which stands in that frame's xz plane.
void lead_to(const Line& line, const Eigen::Isometry3d& X, Joint& row) {
  const Eigen::Matrix3d R = X.linear().transpose();
  const Vector3d foot = R * (line.foot_of(X.translation()) - X.translation());
  const Vector3d direction = R * line.direction;
  row.beta_rad = angle_without_rounding(beta_to(foot, direction));
  row.a_mm = without_rounding(foot.x() * std::cos(row.beta_rad) - foot.z() * std::sin(row.beta_rad));
  const Vector3d tilted = Eigen::AngleAxisd{-row.beta_rad, Vector3d::UnitY()} * direction;
  row.alpha_rad = angle_without_rounding(std::atan2(-tilted.y(), tilted.z()));
}

/// Theta and d that turn and shift a frame on its z axis to have this origin and x axis.
void place(const Eigen::Isometry3d& X, const Vector3d& origin, const Vector3d& x, Joint& row) {
  row.theta_rad = angle_without_rounding(std::atan2(x.dot(X.linear().col(1)), x.dot(X.linear().col(0))));
  row.d_mm = without_rounding((origin - X.translation()).dot(X.linear().col(2)));
}

/// Of the two x axes that lead to the next axis, the one that turns by less; at a right angle the one on
/// which the next axis stands in front.
Vector3d nearer(const Vector3d& x, const Eigen::Isometry3d& X, double next_a_mm) {
  const double along = x.dot(X.linear().col(0));
  if (std::abs(along) > 1e-6) return along < 0 ? Vector3d{-x} : x;
  if (std::abs(next_a_mm) > kNoLength) return next_a_mm < 0 ? Vector3d{-x} : x;
  return x.dot(X.linear().col(1)) > 0 ? Vector3d{-x} : x;
}

/// Ends a joint's row where the next row can lead to `next`.
void place_for(const Line& line, const Line& next, const Eigen::Isometry3d& X, Joint& row) {
  const Vector3d normal = line.direction.cross(next.direction);
  if (normal.norm() > kParallel) {
    const Vector3d origin = nearest_to(line, next), x = normal.normalized();
    return place(X, origin, nearer(x, X, x.dot(nearest_to(next, line) - origin)), row);
  }
  const Vector3d origin = X.translation();
  const Vector3d to_next = square_to(next.foot_of(origin) - origin, line.direction);
  Vector3d x = X.linear().col(0);
  if (to_next.norm() > kNoLength) {
    x = nearer(to_next.normalized(), X, to_next.norm());
  } else if (normal.norm() > kNoAngle) {
    x = nearer(normal.normalized(), X, 0);
  }
  place(X, origin, x, row);
}

/// The last row: the flange's origin and x axis as far as its z axis can reach them.
void place_for(const Line& line, const Eigen::Isometry3d& X_BF, const Eigen::Isometry3d& X, Joint& row) {
  Vector3d x = square_to(X_BF.linear().col(0), line.direction);
  if (x.norm() < 0.5) x = square_to(X_BF.linear().col(1), line.direction);
  place(X, line.foot_of(X_BF.translation()), x.normalized(), row);
}

RobotModel rows_of(const std::vector<Line>& lines, std::span<const JointAxis> axes,
                   const std::vector<double>& signs, const Eigen::Isometry3d& X_BF) {
  RobotModel robot;
  Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
  for (std::size_t i = 0; i < lines.size(); ++i) {
    Joint row = axes[i].joint;
    row.sign = signs[i];
    row.theta_rad = row.d_mm = 0;
    lead_to(lines[i], X, row);
    const Eigen::Isometry3d X_led = X * link_transform(row, 0);
    if (i + 1 < lines.size()) {
      place_for(lines[i], lines[i + 1], X_led, row);
    } else {
      place_for(lines[i], X_BF, X_led, row);
    }
    X = X * link_transform(row, 0);
    robot.joints.push_back(row);
  }
  robot.X_flange = inverse_of(X) * X_BF;
  return robot;
}

}  // namespace

ArmOfAxes arm_of_axes(std::span<const JointAxis> axes, const Eigen::Isometry3d& X_BF) {
  ArmOfAxes arm;
  const Line first{axes[0].point_B_mm, axes[0].direction_B};
  const Vector3d foot = first.foot_of(Vector3d::Zero());
  if (std::abs(foot.y()) > kNoLength) arm.X_base.translation() = foot;
  std::vector<Line> lines;
  std::vector<double> signs;
  for (const JointAxis& axis : axes) {
    lines.push_back({axis.point_B_mm - arm.X_base.translation(), axis.direction_B.normalized()});
    signs.push_back(1);
  }
  const Eigen::Isometry3d X_F = inverse_of(arm.X_base) * X_BF;
  const auto turn_round = [&](std::size_t i) {
    lines[i].direction = -lines[i].direction;
    signs[i] = -signs[i];
  };
  // The z axis of a joint may stand either way: as that of the joint before where both are parallel. Then
  // those that would make d negative are turned round together.
  std::vector<std::size_t> first_of_parallel{0};
  for (std::size_t i = 1; i < lines.size(); ++i) {
    const bool parallel = lines[i].direction.cross(lines[i - 1].direction).norm() < kParallel;
    if (parallel && lines[i].direction.dot(lines[i - 1].direction) < 0) turn_round(i);
    first_of_parallel.push_back(parallel ? first_of_parallel.back() : i);
  }
  std::vector<double> length(lines.size(), 0.0);
  const RobotModel as_given = rows_of(lines, axes, signs, X_F);
  for (std::size_t i = 0; i < lines.size(); ++i) length[first_of_parallel[i]] += as_given.joints[i].d_mm;
  for (std::size_t i = 0; i < lines.size(); ++i) {
    if (length[first_of_parallel[i]] < -kNoLength) turn_round(i);
  }
  arm.robot = rows_of(lines, axes, signs, X_F);
  return arm;
}

}  // namespace truepose
