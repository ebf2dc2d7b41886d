#include "core/plan/design.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "core/data/calibrated_cell.hpp"
#include "core/fit/measurement_model.hpp"
#include "core/math/dense_algebra.hpp"
#include "core/quality/cramer_rao.hpp"

namespace truepose {
namespace {

using kernels::kMostLanes;

// Whose unscaled rows are held at a time, so that they stay in the cache.
constexpr std::size_t kCandidatesAtATime = 256;

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
                             const DesignPrior& prior, std::span<const int> seen)
    : candidates_{candidates.size()} {
  const Eigen::VectorXd scale = scales(cell, prior);
  task_rows_ = position_jacobian(cell, task) * scale.asDiagonal();
  task_ = gram(task_rows_) / static_cast<double>(task.size());

  const auto columns = static_cast<std::size_t>(scale.size());
  blocks_.assign((candidates_ + kMostLanes - 1) / kMostLanes * 3 * columns, {});
  Eigen::VectorXd p_WS_mm;
  Eigen::MatrixXd J;
  for (std::size_t first = 0; first < candidates_; first += kCandidatesAtATime) {
    const std::size_t count = std::min(kCandidatesAtATime, candidates_ - first);
    predict_with_jacobian(cell, candidates.subspan(first, count), p_WS_mm, J);
    for (std::size_t k = 0; k < count; ++k) {
      const auto row = static_cast<Eigen::Index>(3 * k);
      const int reflector = seen.empty() ? 0 : seen[first + k];
      if (reflector > 0) {
        PointJacobian of_it;
        p_WS_mm.segment<3>(row) = predict_with_jacobian(cell, candidates[first + k], reflector, of_it);
        J.middleRows<3>(row) = of_it;
      }
      const Eigen::Matrix3d whitening = inverse_cholesky(reading_covariance(p_WS_mm.segment<3>(row), noise));
      put_rows(first + k, whitening.lazyProduct(J.middleRows<3>(row)) * scale.asDiagonal());
    }
  }
}

void DesignProblem::put_rows(std::size_t candidate, const Rows& rows) {
  const auto columns = static_cast<std::size_t>(parameters());
  kernels::Line* block = &blocks_[candidate / kMostLanes * 3 * columns];
  for (std::size_t i = 0; i < 3 * columns; ++i) {
    block[i].value[candidate % kMostLanes] =
        rows(static_cast<Eigen::Index>(i / columns), static_cast<Eigen::Index>(i % columns));
  }
}

DesignProblem::Rows DesignProblem::rows(std::size_t candidate) const {
  Rows rows(3, parameters());
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
  gain_.resize(blocks);
  if (T_.size() > 0) W_.resize(6 * blocks);
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
  V_before_ = V_;
  W_before_ = W_;
  C_before_ = C_;
  change(candidate, -1);
  is_chosen_[candidate] = false;
  std::erase(chosen_, candidate);
}

void Design::take_back(std::size_t removed) {
  std::swap(V_, V_before_);
  std::swap(W_, W_before_);
  std::swap(C_, C_before_);
  is_chosen_[removed] = true;
  chosen_.push_back(removed);
}

/// C changes by - sign U U', with U U' = C A' (I + sign A C A')^-1 A C.
void Design::change(std::size_t candidate, double sign) {
  const auto A = problem_.rows(candidate);
  const Rows AC = times(A, C_);
  const Eigen::Matrix3d ACA = times_transposed(AC, A);
  const Rows Ut = times(inverse_cholesky(Eigen::Matrix3d::Identity() + sign * ACA), AC);
  if (T_.size() > 0) {
    const Rows UtT = times(Ut, T_);
    const Eigen::Matrix3d UTU = times_transposed(UtT, Ut);
    Eigen::Matrix<double, 6, Eigen::Dynamic> UtPt(6, Ut.cols());
    UtPt << Ut, times(UtT, C_) - sign / 2 * times(UTU, Ut);
    kernels_.add_products(data(problem_.blocks()), blocks_, columns(), UtPt.data(), -sign, data(V_),
                          data(W_));
  } else {
    kernels_.add_squares(data(problem_.blocks()), blocks_, columns(), Ut.data(), -sign, data(V_));
  }
  C_ -= sign * gram(Ut);
}

void Design::refresh() {
  C_ = CholeskyFactor(information(problem_, chosen_)).inverse();
  reckon_congruences(C_, V_);
  if (T_.size() == 0) return;
  reckon_congruences(congruence(C_, T_), W_);
  reckon_gains();
  best_gain_ = std::ranges::max(std::span{data(gain_), problem_.candidates()});
}

void Design::reckon_congruences(const Eigen::MatrixXd& M, std::vector<kernels::Line>& S) const {
  const auto n = M.cols();
  Rows by_three = Rows::Zero(3, (n + 2) / 3 * n);
  for (Eigen::Index c = 0; c < n; ++c) by_three.row(c % 3).segment(c / 3 * n, n) = M.col(c);
  kernels_.congruences(data(problem_.blocks()), blocks_, columns(), by_three.data(), data(S));
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
