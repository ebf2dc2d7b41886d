#include "core/compensation/constrained_step.hpp"

#include <Eigen/LU>

namespace truepose {
namespace {

constexpr int kMostEquations = kMaxJoints + 4;
using Equations =
    Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::ColMajor, kMostEquations, kMostEquations>;
using Sides = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::ColMajor, kMostEquations, 2>;

/// Keeps the equations of an arm with more joints than tasks solvable: the smallest step is taken. A
/// converged iteration does not feel it, for its steps are 0.
constexpr double kLeastStiffness = 1e-10;

/// x with K x = the given x.
/// @return false where there is none
bool solve(const Equations& K, Sides& x) {
  const Eigen::PartialPivLU<Equations> lu(K);
  const auto& LU = lu.matrixLU();
  x = (lu.permutationP() * x).eval();
  // Column by column: for equations as few as these lu.solve() takes longer than the decomposition.
  const Eigen::Index n = K.rows();
  for (Eigen::Index k = 0; k < n; ++k) {
    for (Eigen::Index side = 0; side < x.cols(); ++side)
      x.col(side).tail(n - k - 1) -= x(k, side) * LU.col(k).tail(n - k - 1);
  }
  for (Eigen::Index k = n - 1; k >= 0; --k) {
    for (Eigen::Index side = 0; side < x.cols(); ++side) {
      x(k, side) /= LU(k, k);
      x.col(side).head(k) -= x(k, side) * LU.col(k).head(k);
    }
  }
  return x.allFinite();
}

}  // namespace

std::optional<WristStep> wrist_step(const PositionTask& task, const Eigen::Vector3d& rotation_error,
                                    double opposite_sense) {
  const Eigen::Index n = task.J.cols();
  const auto J_p = task.J.topRows<3>();
  const auto J_r = task.J.bottomRows<3>();
  // Least squares of the orientation under the constraints J_p step = p_error and opposite part = 0 or 1.
  Equations K = Equations::Zero(n + 4, n + 4);
  K.topLeftCorner(n, n).noalias() = J_r.transpose() * J_r;
  K.diagonal().head(n).array() += kLeastStiffness;
  K.block(n, 0, 3, n) = J_p;
  K(n + 3, n - 3) = 0.5;
  K(n + 3, n - 1) = 0.5 * opposite_sense;
  K.topRightCorner(n, 4) = K.bottomLeftCorner(4, n).transpose();
  Sides x = Sides::Zero(n + 4, 2);
  x.col(0).head(n).noalias() = J_r.transpose() * rotation_error;
  x.col(0).segment<3>(n) = task.p_error;
  x(n + 3, 1) = 1;
  if (!solve(K, x)) return std::nullopt;

  WristStep step{.others = x.col(0).head(n), .opposite = x.col(1).head(n)};
  const Eigen::Vector3d left = rotation_error - J_r * step.others, turned = J_r * step.opposite;
  step.e_squared = left.squaredNorm();
  step.s_squared = turned.squaredNorm();
  step.e_s = left.dot(turned);
  return step;
}

std::optional<JointVector> nearest_step(const PositionTask& task, const JointVector& wanted,
                                        const std::bitset<kMaxJoints>& held) {
  const Eigen::Index n = task.J.cols();
  Equations K = Equations::Zero(n + 3, n + 3);
  K.diagonal().head(n).setOnes();
  K.block(n, 0, 3, n) = task.J.topRows<3>();
  for (Eigen::Index i = 0; i < n; ++i) {
    if (!held[static_cast<std::size_t>(i)]) K.block(i, n, 1, 3) = K.block(n, i, 3, 1).transpose();
  }
  Sides x = Sides::Zero(n + 3, 1);
  x.col(0).head(n) = wanted;
  x.col(0).tail<3>() = task.p_error;
  if (!solve(K, x)) return std::nullopt;
  return JointVector(x.col(0).head(n));
}

}  // namespace truepose
