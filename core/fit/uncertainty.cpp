#include "core/fit/uncertainty.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/arm/forward.hpp"
#include "core/fit/identifiability.hpp"
#include "core/fit/measurement_model.hpp"
#include "core/math/dense_algebra.hpp"
#include "core/math/random.hpp"

namespace truepose {
namespace {

/// (J'J)^-1 by the pseudo-inverse at unit column norm.
InverseGram inverse_of_normal_matrix(const Eigen::MatrixXd& J) {
  const Eigen::VectorXd inverse_norm = column_norms(J).cwiseInverse();
  InverseGram inverse = inverse_gram(J * inverse_norm.asDiagonal(), kRankTolerance);
  inverse.value = inverse_norm.asDiagonal() * inverse.value * inverse_norm.asDiagonal();
  return inverse;
}

}  // namespace

ParameterUncertainty uncertainty_of(const LinearSystem& system, const LeastSquaresProblem& problem,
                                    int parameters, int equations) {
  const auto [inverse, rank] = inverse_of_normal_matrix(system.J);
  const auto weight = [&](std::size_t i) {
    return problem.prior.weight.size() > 0 ? problem.prior.weight[problem.free[i]] : 0.0;
  };
  ParameterUncertainty result;
  // What the prior says of a parameter, the data do not.
  result.determined = rank;
  for (std::size_t i = 0; i < problem.free.size(); ++i) {
    const auto a = static_cast<Eigen::Index>(i);
    result.determined -= inverse(a, a) * weight(i) * weight(i);
  }

  result.sigma0_mm = problem.prior.sigma_mm > 0
                         ? problem.prior.sigma_mm
                         : std::sqrt(system.f.head(equations).squaredNorm() /
                                     std::max(1.0, equations - system.mountings - result.determined));
  result.covariance = Eigen::MatrixXd::Zero(parameters, parameters);
  result.data_share = Eigen::VectorXd::Zero(parameters);
  const double variance0 = result.sigma0_mm * result.sigma0_mm;
  for (std::size_t i = 0; i < problem.free.size(); ++i) {
    const auto a = static_cast<Eigen::Index>(i);
    for (std::size_t j = 0; j < problem.free.size(); ++j) {
      result.covariance(problem.free[i], problem.free[j]) =
          variance0 * inverse(a, static_cast<Eigen::Index>(j));
    }
    result.data_share[problem.free[i]] = std::clamp(1 - inverse(a, a) * weight(i) * weight(i), 0.0, 1.0);
  }
  return result;
}

Eigen::Matrix3d field_covariance(const CalibratedCell& cell, const JointVector& q,
                                 const Eigen::Vector3d& p_F_mm, Approach approach, int station) {
  if (!cell.robot.field) return Eigen::Matrix3d::Zero();
  const Eigen::Matrix3d R_WB = cell.base_at(station).isometry().linear();
  const Eigen::Isometry3d X_BF = forward_kinematics(cell.robot, q, approach);
  return R_WB * cell.robot.field->covariance(q, X_BF, p_F_mm) * R_WB.transpose();
}

Eigen::Matrix3d position_covariance(const CalibratedCell& cell, const Eigen::MatrixXd& covariance,
                                    const JointVector& q, int smr, Approach approach, int station) {
  PointJacobian J;
  predict_with_jacobian(cell, q, smr, J, approach, station);
  return congruence(J, covariance) +
         field_covariance(cell, q, cell.reflectors[static_cast<std::size_t>(smr)].p_FS_mm, approach, station);
}

std::vector<JointVector> poses_within_limits(const RobotModel& robot, int count, std::uint64_t seed) {
  Random random(seed);
  std::vector<JointVector> poses;
  poses.reserve(static_cast<std::size_t>(count));
  for (int n = 0; n < count; ++n) {
    JointVector q(robot.joint_count());
    for (int i = 0; i < robot.joint_count(); ++i) {
      const Joint& joint = robot.joints[static_cast<std::size_t>(i)];
      const bool turns = joint.type == JointType::Revolute;
      const double low = turns ? std::max(joint.min, -std::numbers::pi) : joint.min;
      const double high = turns ? std::min(joint.max, std::numbers::pi) : joint.max;
      q[i] = random.uniform(low, high);
    }
    poses.push_back(q);
  }
  return poses;
}

TransferUncertainty transfer_uncertainty(const CalibratedCell& cell, const Eigen::MatrixXd& covariance,
                                         std::span<const JointVector> poses) {
  Eigen::VectorXd variances = position_variances(cell, covariance, poses);
  for (std::size_t n = 0; n < poses.size(); ++n)
    variances[static_cast<Eigen::Index>(n)] +=
        field_covariance(cell, poses[n], cell.reflectors.front().p_FS_mm).trace();
  Eigen::Index worst = 0;
  const double most = variances.maxCoeff(&worst);
  return {.rms_mm = std::sqrt(variances.mean()),
          .max_mm = std::sqrt(most),
          .worst = poses[static_cast<std::size_t>(worst)]};
}

}  // namespace truepose
