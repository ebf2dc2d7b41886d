#include "core/change/joint_errors.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include "core/change/reduced_equations.hpp"
#include "core/math/dense_algebra.hpp"

namespace truepose {
namespace {

constexpr int kMostHarmonics = 2;

/// Where in its turn a joint stands; of a rail, in its travel.
double phase_rad(const Joint& joint, double q) {
  if (joint.type == JointType::Revolute) return q;
  return joint.max > joint.min ? 2 * std::numbers::pi * (q - joint.min) / (joint.max - joint.min) : 0;
}

/// Columns of parameters, each times sine and cosine of every harmonic of a joint.
Eigen::MatrixXd columns_of(const CalibratedCell& cell, const TimeEvidence& evidence,
                           std::span<const Measurement> points, int joint, const PossibleChange& entries,
                           int harmonics) {
  const Eigen::MatrixXd J = times(evidence.J, directions_of({&entries, 1}, cell));
  const Eigen::Index count = J.cols();
  Eigen::MatrixXd columns(J.rows(), 2 * harmonics * count);
  for (std::size_t i = 0; i < points.size(); ++i) {
    const double phase = phase_rad(cell.robot.joints[static_cast<std::size_t>(joint)], points[i].q[joint]);
    for (int h = 0; h < harmonics; ++h) {
      columns.block(row_of(i), 2 * h * count, 3, count) =
          std::sin((h + 1) * phase) * J.middleRows<3>(row_of(i));
      columns.block(row_of(i), (2 * h + 1) * count, 3, count) =
          std::cos((h + 1) * phase) * J.middleRows<3>(row_of(i));
    }
  }
  return columns;
}

/// Of columns over no change.
ChangeFound found_by(const ChangeHypothesis& change, const Eigen::MatrixXd& columns,
                     const TimeEvidence& evidence) {
  ReducedEquations equations{evidence, columns.cols()};
  for (std::size_t i = 0; row_of(i) < columns.rows(); ++i)
    equations.add(evidence, i, columns.middleRows<3>(row_of(i)));
  return {change, equations.evidence(evidence).best(), {}, {}};
}

/// The one of the largest evidence, with the prior of its hypothesis, which all share.
ChangeFound best_of(std::span<const ChangeFound> all) {
  ChangeFound best = *std::ranges::max_element(all, {}, &ChangeFound::evidence);
  best.evidence += std::log(row_of(best).prior / static_cast<double>(all.size()));
  return best;
}

}  // namespace

ChangeFound likeliest_joint_errors(const CalibratedCell& cell, const TimeEvidence& evidence,
                                   std::span<const Measurement> points) {
  const std::vector<PossibleChange> zeros = joint_zeros_of(cell);
  std::vector<ChangeFound> all;
  for (int joint = 0; joint < cell.robot.joint_count(); ++joint) {
    PossibleChange link{{ChangeKind::Link}, first_parameters(ParameterLayout::kLink)};
    for (int& parameter : link.free) parameter += ParameterLayout::of(cell).link(joint);
    for (const PossibleChange& entries : {zeros[static_cast<std::size_t>(joint)], link})
      for (int harmonics = 1; harmonics <= kMostHarmonics; ++harmonics)
        all.push_back(found_by({{ChangeKind::JointErrors, joint}, TimeProfile::ByAngle},
                               columns_of(cell, evidence, points, joint, entries, harmonics), evidence));
  }
  return best_of(all);
}

ChangeFound warm_up(const CalibratedCell& cell, const TimeEvidence& evidence,
                    std::span<const Measurement> points) {
  const std::vector<int> pose = pose_numbers(points);
  const std::array warmed{all_zeros_of(cell), growth_of(cell)};
  const Eigen::MatrixXd warm = times(evidence.J, directions_of(warmed, cell));
  std::vector<ChangeFound> all;
  for (const double share : {1.0 / 16, 1.0 / 8, 1.0 / 4, 1.0 / 2}) {
    const double constant = share * count_poses(points);
    Eigen::MatrixXd columns = warm;
    for (std::size_t i = 0; i < points.size(); ++i)
      columns.middleRows<3>(row_of(i)) *= -std::expm1(-pose[i] / constant);
    all.push_back(found_by({{ChangeKind::WarmUp}, TimeProfile::Exponential}, columns, evidence));
  }
  return best_of(all);
}

}  // namespace truepose
