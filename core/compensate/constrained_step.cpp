#include "core/compensate/constrained_step.hpp"

#include <array>

#include "core/math/dense_algebra.hpp"

namespace truepose {
namespace {

/// Keeps an arm with more joints than tasks solvable: the smallest step is taken. A converged iteration does
/// not feel it, for its steps are 0.
constexpr double kLeastStiffness = 1e-10;

/// Four equations in the joints' steps, with two right sides after the joints' columns.
constexpr int kEquations = 4, kSides = 2;
using Equations =
    Eigen::Matrix<double, kEquations, Eigen::Dynamic, Eigen::ColMajor, kEquations, kMaxJoints + kSides>;
using Steps = Eigen::Matrix<double, Eigen::Dynamic, kSides, Eigen::ColMajor, kMaxJoints, kSides>;
using Freedom = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::ColMajor, kMaxJoints,
                              kMaxJoints - kEquations>;

/// What solves the equations: particular + freedom y for any y, one column for each right side.
struct Solutions {
  Steps particular;
  Freedom freedom;
};

/// Gauss-Jordan, each equation solved for the joint that counts most in it.
/// @return nothing where the equations depend on each other
std::optional<Solutions> solutions(Equations table) {
  constexpr double kDependent = 1e-13;
  const Eigen::Index n = table.cols() - kSides;
  Solutions all{Steps::Zero(n, kSides), Freedom::Zero(n, n - kEquations)};
  std::array<Eigen::Index, kEquations> joint_of{};
  std::bitset<kMaxJoints> is_solved;
  for (Eigen::Index r = 0; r < kEquations; ++r) {
    Eigen::Index joint = 0;
    // The joints of the equations before are eliminated from this one.
    const double largest = table.row(r).head(n).cwiseAbs().maxCoeff(&joint);
    if (!(largest > kDependent)) return std::nullopt;
    joint_of[static_cast<std::size_t>(r)] = joint;
    is_solved.set(static_cast<std::size_t>(joint));
    const Eigen::Vector4d eliminated = table.col(joint);
    for (Eigen::Index c = 0; c < table.cols(); ++c) {
      const double value = table(r, c) / eliminated[r];
      table.col(c) -= value * eliminated;
      table(r, c) = value;
    }
  }
  Eigen::Index free = 0;
  for (Eigen::Index i = 0; i < n; ++i) {
    if (is_solved[static_cast<std::size_t>(i)]) continue;
    all.freedom(i, free) = 1;
    for (Eigen::Index r = 0; r < kEquations; ++r)
      all.freedom(joint_of[static_cast<std::size_t>(r)], free) = -table(r, i);
    ++free;
  }
  for (Eigen::Index r = 0; r < kEquations; ++r)
    all.particular.row(joint_of[static_cast<std::size_t>(r)]) = table.row(r).tail<kSides>();
  return all;
}

}  // namespace

std::optional<WristStep> wrist_step(const PositionTask& task, const Eigen::Vector3d& rotation_error,
                                    double opposite_sense) {
  const Eigen::Index n = task.J.cols();
  const auto J_r = task.J.bottomRows<3>();
  // Least squares of the orientation under the constraints J_p step = p_error and opposite part = 0 or 1.
  Equations table = Equations::Zero(kEquations, n + kSides);
  table.topLeftCorner(3, n) = task.J.topRows<3>();
  table(3, n - 3) = 0.5;
  table(3, n - 1) = 0.5 * opposite_sense;
  table.col(n).head<3>() = task.p_error;
  table(3, n + 1) = 1;
  const auto all = solutions(table);
  if (!all) return std::nullopt;
  const Freedom& Z = all->freedom;
  const auto turns = J_r.lazyProduct(Z).eval();
  Eigen::Matrix<double, 3, kSides> wanted = -J_r.lazyProduct(all->particular);
  wanted.col(0) += rotation_error;
  auto H = (turns.transpose().lazyProduct(turns) + kLeastStiffness * Z.transpose().lazyProduct(Z)).eval();
  auto b =
      (turns.transpose().lazyProduct(wanted) - kLeastStiffness * Z.transpose().lazyProduct(all->particular))
          .eval();
  solve_positive_in_place(H, b);
  const Steps x = all->particular + Z.lazyProduct(b);
  if (!x.allFinite()) return std::nullopt;

  WristStep step{.others = x.col(0), .opposite = x.col(1)};
  const Eigen::Vector3d left = rotation_error - J_r * step.others, turned = J_r * step.opposite;
  step.e_squared = left.squaredNorm();
  step.s_squared = turned.squaredNorm();
  step.e_s = left.dot(turned);
  return step;
}

std::optional<JointVector> nearest_step(const PositionTask& task, const JointVector& wanted,
                                        const std::bitset<kMaxJoints>& held) {
  constexpr int kMost = kMaxJoints + 3;
  const Eigen::Index n = task.J.cols();
  using Matrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::ColMajor, kMost, kMost>;
  Matrix K = Matrix::Zero(n + 3, n + 3);
  K.diagonal().head(n).setOnes();
  K.block(n, 0, 3, n) = task.J.topRows<3>();
  for (Eigen::Index i = 0; i < n; ++i) {
    if (!held[static_cast<std::size_t>(i)]) K.block(i, n, 1, 3) = K.block(n, i, 3, 1).transpose();
  }
  Eigen::Matrix<double, Eigen::Dynamic, 1, Eigen::ColMajor, kMost, 1> x(n + 3);
  x << wanted, task.p_error;
  solve_in_place(K, x);
  if (!x.allFinite()) return std::nullopt;
  return JointVector(x.head(n));
}

}  // namespace truepose
