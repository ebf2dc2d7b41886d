#include "core/change/joint_errors.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include "core/fit/identifiability.hpp"
#include "core/math/dense_algebra.hpp"
#include "core/math/statistics.hpp"

namespace truepose {
namespace {

constexpr int kMostHarmonics = 2;
constexpr double kAlike = 1e-6;  // of a column: what the parameters do not take up of it is rounding

/// Where in its turn a joint stands; of a rail, in its travel.
double phase_rad(const Joint& joint, double q) {
  if (joint.type == JointType::Revolute) return q;
  return joint.max > joint.min ? 2 * std::numbers::pi * (q - joint.min) / (joint.max - joint.min) : 0;
}

/// The columns of a joint's link, each times sine and cosine of every harmonic.
Eigen::MatrixXd columns_of(const CalibratedCell& cell, const TimeEvidence& evidence,
                           std::span<const Measurement> points, int joint, int harmonics) {
  constexpr int kLink = ParameterLayout::kLink;
  const int link = ParameterLayout::of(cell).link(joint);
  Eigen::MatrixXd columns(evidence.J.rows(), 2 * harmonics * kLink);
  for (std::size_t i = 0; i < points.size(); ++i) {
    const double phase = phase_rad(cell.robot.joints[static_cast<std::size_t>(joint)], points[i].q[joint]);
    const Eigen::Matrix<double, 3, kLink> J = evidence.J.block<3, kLink>(row_of(i), link);
    for (int h = 0; h < harmonics; ++h) {
      columns.block<3, kLink>(row_of(i), 2 * h * kLink) = std::sin((h + 1) * phase) * J;
      columns.block<3, kLink>(row_of(i), (2 * h + 1) * kLink) = std::cos((h + 1) * phase) * J;
    }
  }
  return columns;
}

/// Akaike's criterion of columns in addition to the parameters.
///
/// @param chosen  so many further numbers were chosen by the points
double criterion_of(const Eigen::MatrixXd& columns, const TimeEvidence& evidence, int chosen = 0) {
  const Eigen::MatrixXd unit = columns * column_norms(columns).cwiseInverse().asDiagonal();
  const Svd svd = thin_svd(unit - times(evidence.U, transposed_times(evidence.U, unit)));
  const Eigen::Index unknowns = (svd.s.array() > kAlike).count();
  const double gain = transposed_times(svd.U.leftCols(unknowns), evidence.r).squaredNorm();
  return akaike_criterion(std::max(0.0, evidence.r.squaredNorm() - gain), evidence.degrees,
                          static_cast<int>(unknowns) + chosen);
}

}  // namespace

JointErrors likeliest_joint_errors(const CalibratedCell& cell, const TimeEvidence& evidence,
                                   std::span<const Measurement> points) {
  JointErrors likeliest;
  for (int joint = 0; joint < cell.robot.joint_count(); ++joint) {
    for (int harmonics = 1; harmonics <= kMostHarmonics; ++harmonics) {
      const double criterion = criterion_of(columns_of(cell, evidence, points, joint, harmonics), evidence);
      if (criterion < likeliest.criterion) likeliest = {joint, criterion};
    }
  }
  return likeliest;
}

double warm_up_criterion(const CalibratedCell& cell, const TimeEvidence& evidence,
                         std::span<const Measurement> points) {
  const ParameterLayout layout = ParameterLayout::of(cell);
  const std::vector<int> pose = pose_numbers(points);
  Eigen::MatrixXd warm(evidence.J.rows(), layout.joints + 1);
  warm.col(layout.joints).setZero();
  for (int i = 0; i < layout.joints; ++i) {
    constexpr int kA = 0, kD = 2;  // of ParameterLayout's five
    const Joint& joint = cell.robot.joints[static_cast<std::size_t>(i)];
    warm.col(i) = evidence.J.col(zero_parameter(cell.robot, layout, i));
    warm.col(layout.joints) +=
        joint.a_mm * evidence.J.col(layout.link(i) + kA) + joint.d_mm * evidence.J.col(layout.link(i) + kD);
  }
  double best = std::numeric_limits<double>::infinity();
  for (const double share : {1.0 / 16, 1.0 / 8, 1.0 / 4, 1.0 / 2}) {
    const double constant = share * count_poses(points);
    Eigen::MatrixXd columns = warm;
    for (std::size_t i = 0; i < points.size(); ++i)
      columns.middleRows<3>(row_of(i)) *= -std::expm1(-pose[i] / constant);
    best = std::min(best, criterion_of(columns, evidence, 1));
  }
  return best;
}

}  // namespace truepose
