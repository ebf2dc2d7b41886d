#include "core/calibration/uncertainty.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/calibration/identifiability.hpp"
#include "core/calibration/measurement_model.hpp"
#include "core/linear_algebra/decompositions.hpp"
#include "core/random.hpp"

namespace truepose {
namespace {

/// (J'J)^-1 by the pseudo-inverse at unit column norm.
Eigen::MatrixXd inverse_of_normal_matrix(const Eigen::MatrixXd& J) {
  const Eigen::VectorXd inverse_norm = column_norms(J).cwiseInverse();
  const Svd svd = thin_svd(J * inverse_norm.asDiagonal());
  const Eigen::VectorXd variance =
      svd.s.unaryExpr([&](double v) { return v > kRankTolerance * svd.s[0] ? 1 / (v * v) : 0.0; });
  const Eigen::MatrixXd scaled = inverse_norm.asDiagonal() * svd.V;
  return scaled * variance.asDiagonal() * scaled.transpose();
}

}  // namespace

ParameterUncertainty uncertainty_of(const LinearSystem& system, const LeastSquaresProblem& problem,
                                    int parameters, int equations) {
  const Eigen::Index data_rows = 3 * static_cast<Eigen::Index>(problem.points.size());
  const auto J_data = system.J.topRows(data_rows);
  const Eigen::MatrixXd inverse = inverse_of_normal_matrix(system.J);
  const double determined = (J_data.transpose() * J_data).cwiseProduct(inverse).sum();

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
    const double weight = problem.prior.weight.size() > 0 ? problem.prior.weight[problem.free[i]] : 0.0;
    result.data_share[problem.free[i]] = std::clamp(1 - inverse(a, a) * weight * weight, 0.0, 1.0);
  }
  return result;
}

Eigen::Matrix3d position_covariance(const CalibratedCell& cell, const Eigen::MatrixXd& covariance,
                                    const JointVector& q, int smr) {
  PointJacobian J;
  predict_with_jacobian(cell, q, smr, J);
  return J * covariance * J.transpose();
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
  TransferUncertainty result;
  double sum = 0;
  for (const JointVector& q : poses) {
    const double variance = position_covariance(cell, covariance, q, 0).trace();
    sum += variance;
    if (variance > result.max_mm * result.max_mm) {
      result.max_mm = std::sqrt(variance);
      result.worst = q;
    }
  }
  result.rms_mm = std::sqrt(sum / static_cast<double>(poses.size()));
  return result;
}

}  // namespace truepose
