#include "core/plan/design.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "core/identify/calibrated_cell.hpp"
#include "core/identify/measurement_model.hpp"
#include "core/judge/cramer_rao.hpp"
#include "core/math/dense_algebra.hpp"

namespace truepose {
namespace {

using PoseRows = Eigen::Matrix<double, 3, Eigen::Dynamic>;
using kernels::kMostLanes;

Eigen::VectorXd scales(const CalibratedCell& cell, const DesignPrior& prior) {
  const ParameterLayout layout = ParameterLayout::of(cell);
  Eigen::VectorXd scale = Eigen::VectorXd::Zero(layout.size());
  scale.head<3>().setConstant(prior.base_mm);
  scale.segment<3>(3).setConstant(prior.base_rad);
  scale.segment(ParameterLayout::kBase, ParameterLayout::kReflector * layout.reflectors)
      .setConstant(prior.reflector_mm);
  for (int i = 0; i < layout.joints; ++i) {
    scale.segment<ParameterLayout::kLink>(layout.link(i)) << prior.length_mm, prior.angle_rad,
        prior.length_mm, prior.angle_rad, prior.angle_rad;
  }
  return scale;  // coefficients of deviations are left as they are: 0, known
}

}  // namespace

DesignProblem::DesignProblem(const CalibratedCell& cell, std::span<const JointVector> candidates,
                             std::span<const JointVector> task, const MeasurementNoise& noise,
                             const DesignPrior& prior)
    : candidates_{candidates.size()} {
  const Eigen::VectorXd scale = scales(cell, prior);
  task_rows_ = position_jacobian(cell, task) * scale.asDiagonal();
  task_ = gram(task_rows_) / static_cast<double>(task.size());

  const auto columns = static_cast<std::size_t>(scale.size());
  blocks_.assign((candidates_ + kMostLanes - 1) / kMostLanes * 3 * columns, {});
  PointJacobian J;
  for (std::size_t k = 0; k < candidates_; ++k) {
    const Eigen::Vector3d p_WS_mm = predict_with_jacobian(cell, candidates[k], 0, J);
    const PoseRows whitened =
        times(inverse_cholesky(reading_covariance(p_WS_mm, noise)), J * scale.asDiagonal());
    kernels::Line* block = &blocks_[k / kMostLanes * 3 * columns];
    for (std::size_t i = 0; i < 3 * columns; ++i) {
      block[i].value[k % kMostLanes] =
          whitened(static_cast<Eigen::Index>(i / columns), static_cast<Eigen::Index>(i % columns));
    }
  }
}

Eigen::Matrix<double, 3, Eigen::Dynamic> DesignProblem::rows(std::size_t candidate) const {
  PoseRows rows(3, parameters());
  const auto columns = static_cast<std::size_t>(parameters());
  const kernels::Line* block = &blocks_[candidate / kMostLanes * 3 * columns];
  for (std::size_t i = 0; i < 3 * columns; ++i) {
    rows(static_cast<Eigen::Index>(i / columns), static_cast<Eigen::Index>(i % columns)) =
        block[i].value[candidate % kMostLanes];
  }
  return rows;
}

namespace {

// The first poses lower W by many powers of ten, of which each takes a digit.
constexpr double kWorn = 1e-4;

double* data(std::vector<kernels::Line>& lines) { return lines.front().value; }
const double* data(const std::vector<kernels::Line>& lines) { return lines.front().value; }

Eigen::MatrixXd information(const DesignProblem& problem, std::span<const std::size_t> chosen) {
  Eigen::MatrixXd M = Eigen::MatrixXd::Identity(problem.parameters(), problem.parameters());
  for (const std::size_t k : chosen) {
    M += gram(problem.rows(k));
  }
  return M;
}

}  // namespace

Design::Design(const DesignProblem& problem, DesignCriterion criterion, const kernels::Kernels& kernels)
    : problem_{problem},
      kernels_{kernels},
      blocks_{static_cast<int>((problem.candidates() + kernels::kMostLanes - 1) / kernels::kMostLanes)},
      is_chosen_(problem.candidates()) {
  const auto n = problem.parameters();
  if (criterion == DesignCriterion::A) T_ = Eigen::MatrixXd::Identity(n, n);
  if (criterion == DesignCriterion::I) T_ = problem.task();
  const auto blocks = static_cast<std::size_t>(blocks_);
  V_.resize(6 * blocks);
  X_.resize(9 * blocks);
  gain_.resize(blocks);
  if (T_.size() > 0) {
    W_.resize(6 * blocks);
    Y_.resize(9 * blocks);
  }
  refresh();
}

void Design::add(std::size_t candidate) {
  assert(!is_chosen_[candidate]);
  change(candidate, 1);
  is_chosen_[candidate] = true;
  chosen_.push_back(candidate);
}

void Design::remove(std::size_t candidate) {
  assert(is_chosen_[candidate]);
  change(candidate, -1);
  is_chosen_[candidate] = false;
  std::erase(chosen_, candidate);
}

/// C changes by - sign U U', with U U' = C A' (I + sign A C A')^-1 A C.
void Design::change(std::size_t candidate, double sign) {
  const auto A = problem_.rows(candidate);
  const Rows AC = times(A, C_);
  const Eigen::Matrix3d ACA = times_transposed(AC, A);
  const Rows Ut = times(inverse_cholesky(Eigen::Matrix3d::Identity() + sign * ACA), AC);
  project(Ut, X_);
  add_products(X_, X_, -sign / 2, V_);
  if (T_.size() > 0) {
    const Rows UtT = times(Ut, T_);
    const Eigen::Matrix3d UTU = times_transposed(UtT, Ut);
    project(times(UtT, C_) - sign / 2 * times(UTU, Ut), Y_);
    add_products(X_, Y_, -sign, W_);
  }
  C_ -= sign * gram(Ut);
}

void Design::refresh() {
  C_ = CholeskyFactor(information(problem_, chosen_)).inverse();
  std::ranges::fill(V_, kernels::Line{});
  std::ranges::fill(W_, kernels::Line{});
  // C = L L' and T = R'R, three columns at a time.
  const Eigen::MatrixXd L = CholeskyFactor(C_).L();
  const Eigen::MatrixXd CTC = T_.size() > 0 ? congruence(C_, T_) : Eigen::MatrixXd{};
  const auto n = C_.cols();
  for (Eigen::Index first = 0; first < n; first += 3) {
    const auto count = std::min<Eigen::Index>(3, n - first);
    Rows Ut = Rows::Zero(3, n);
    Ut.topRows(count) = L.middleCols(first, count).transpose();
    project(Ut, X_);
    add_products(X_, X_, 0.5, V_);
    if (T_.size() == 0) continue;
    Ut.setZero();
    Ut.topRows(count) = CTC.middleCols(first, count).transpose();
    project(Ut, X_);
    Ut.setZero();
    for (Eigen::Index i = 0; i < count; ++i) Ut(i, first + i) = 1;
    project(Ut, Y_);
    add_products(X_, Y_, 0.5, W_);
  }
  if (T_.size() == 0) return;
  reckon_gains();
  best_gain_ = std::ranges::max(std::span{data(gain_), problem_.candidates()});
}

std::span<const double> Design::gains() {
  reckon_gains();
  const std::span<const double> gains{data(gain_), problem_.candidates()};
  if (T_.size() == 0) return gains;  // the logarithm of a determinant does not need every digit
  if (std::ranges::max(gains) < kWorn * best_gain_) refresh();
  return gains;
}

void Design::reckon_gains() {
  if (T_.size() > 0) {
    kernels_.variance_gains(data(V_), data(W_), blocks_, data(gain_));
  } else {
    kernels_.volume_gains(data(V_), blocks_, data(gain_));
  }
}

double Design::cost() const {
  if (T_.size() > 0) return T_.cwiseProduct(C_).sum();
  return CholeskyFactor(C_).log_determinant();
}

void Design::project(const Rows& Ut, std::vector<kernels::Line>& X) const {
  kernels_.project(data(problem_.blocks()), blocks_, static_cast<int>(problem_.parameters()), Ut.data(),
                   data(X));
}

void Design::add_products(const std::vector<kernels::Line>& X, const std::vector<kernels::Line>& Y,
                          double factor, std::vector<kernels::Line>& S) const {
  kernels_.add_products(data(X), data(Y), factor, blocks_, data(S));
}

PredictedError predicted_error(const DesignProblem& problem, const Eigen::MatrixXd& covariance) {
  const Eigen::MatrixXd& J = problem.task_rows();
  const Eigen::VectorXd variance = congruence_diagonal(J, covariance);
  PredictedError error;
  for (Eigen::Index i = 0; i < variance.size(); i += 3) {
    error.rms_mm += variance.segment<3>(i).sum();
    error.max_mm = std::max(error.max_mm, std::sqrt(variance.segment<3>(i).sum()));
  }
  error.rms_mm = std::sqrt(error.rms_mm * 3 / static_cast<double>(variance.size()));
  return error;
}

PredictedError predicted_error(const DesignProblem& problem, std::span<const std::size_t> chosen) {
  return predicted_error(problem, CholeskyFactor(information(problem, chosen)).inverse());
}

}  // namespace truepose
