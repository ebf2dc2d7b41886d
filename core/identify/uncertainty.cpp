#include "core/identify/uncertainty.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/identify/identifiability.hpp"
#include "core/identify/measurement_model.hpp"
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
  const Eigen::Index data_rows = 3 * static_cast<Eigen::Index>(problem.points.size());
  const auto [inverse, rank] = inverse_of_normal_matrix(system.J);
  const auto weight = [&](std::size_t i) {
    return problem.prior.weight.size() > 0 ? problem.prior.weight[problem.free[i]] : 0.0;
  };
  // What the prior says of a parameter, the data do not.
  double determined = rank;
  for (std::size_t i = 0; i < problem.free.size(); ++i) {
    const auto a = static_cast<Eigen::Index>(i);
    determined -= inverse(a, a) * weight(i) * weight(i);
  }

  ParameterUncertainty result;
  result.sigma0_mm =
      std::sqrt(system.f.head(data_rows).squaredNorm() / std::max(1.0, equations - determined));
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

Eigen::Matrix3d position_covariance(const CalibratedCell& cell, const Eigen::MatrixXd& covariance,
                                    const JointVector& q, int smr) {
  PointJacobian J;
  predict_with_jacobian(cell, q, smr, J);
  return congruence(J, covariance);
}

std::vector<JointVector> poses_within_limits(const RobotModel& robot, int count, std::uint64_t seed) {
  Random random(seed);
  std::vector<JointVector> poses;
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
  std::vector<Measurement> points;
  for (const JointVector& q : poses) points.push_back({.q = q, .p_WS_mm = Eigen::Vector3d::Zero()});
  Eigen::VectorXd f;
  Eigen::MatrixXd J;
  residuals_with_jacobian(cell, points, f, J);
  std::vector<Eigen::Index> known;
  for (Eigen::Index k = 0; k < covariance.rows(); ++k) {
    if (covariance(k, k) > 0) known.push_back(k);
  }
  const Eigen::MatrixXd J_known = J(Eigen::all, known);
  const Eigen::VectorXd variances = congruence_diagonal(J_known, covariance(known, known));

  TransferUncertainty result;
  for (std::size_t n = 0; n < poses.size(); ++n) {
    const double variance = variances.segment<3>(3 * static_cast<Eigen::Index>(n)).sum();
    if (variance <= result.max_mm * result.max_mm) continue;
    result.max_mm = std::sqrt(variance);
    result.worst = poses[n];
  }
  result.rms_mm = std::sqrt(variances.sum() / static_cast<double>(poses.size()));
  return result;
}

}  // namespace truepose
