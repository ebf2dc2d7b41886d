#include "core/planning/design.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cassert>
#include <cmath>

namespace truepose {
namespace {

// The first poses lower W by many powers of ten, of which each takes a digit.
constexpr double kWorn = 1e-4;

double* data(std::vector<kernels::Line>& lines) { return lines.front().value; }
const double* data(const std::vector<kernels::Line>& lines) { return lines.front().value; }

Eigen::MatrixXd information(const DesignProblem& problem, std::span<const std::size_t> chosen) {
  Eigen::MatrixXd M = Eigen::MatrixXd::Identity(problem.parameters(), problem.parameters());
  for (const std::size_t k : chosen) {
    const auto A = problem.rows(k);
    M.noalias() += A.transpose() * A;
  }
  return M;
}

Eigen::MatrixXd inverse(const Eigen::MatrixXd& M) {
  return M.llt().solve(Eigen::MatrixXd::Identity(M.rows(), M.cols()));
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
  const Columns CA = C_ * A.transpose();
  const Eigen::Matrix3d S = Eigen::Matrix3d::Identity() + sign * A * CA;
  const Columns U = S.llt().matrixL().solve(CA.transpose()).transpose();
  project(U, X_);
  add_products(X_, X_, -sign / 2, V_);
  if (T_.size() > 0) {
    const Columns TU = T_ * U;
    const Eigen::Matrix3d UTU = U.transpose() * TU;
    project(C_ * TU - sign / 2 * U * UTU, Y_);
    add_products(X_, Y_, -sign, W_);
  }
  C_.noalias() -= sign * U * U.transpose();
}

void Design::refresh() {
  C_ = inverse(information(problem_, chosen_));
  std::ranges::fill(V_, kernels::Line{});
  std::ranges::fill(W_, kernels::Line{});
  // C = L L' and T = R'R, three columns at a time.
  const Eigen::MatrixXd L = C_.llt().matrixL();
  const Eigen::MatrixXd CTC = T_.size() > 0 ? Eigen::MatrixXd{C_ * T_ * C_} : Eigen::MatrixXd{};
  const auto n = C_.cols();
  for (Eigen::Index first = 0; first < n; first += 3) {
    const auto count = std::min<Eigen::Index>(3, n - first);
    Columns U = Columns::Zero(n, 3);
    U.leftCols(count) = L.middleCols(first, count);
    project(U, X_);
    add_products(X_, X_, 0.5, V_);
    if (T_.size() == 0) continue;
    U.setZero();
    U.leftCols(count) = CTC.middleCols(first, count);
    project(U, X_);
    U.setZero();
    for (Eigen::Index i = 0; i < count; ++i) U(first + i, i) = 1;
    project(U, Y_);
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
  return 2 * Eigen::MatrixXd{C_.llt().matrixL()}.diagonal().array().log().sum();
}

void Design::project(const Columns& U, std::vector<kernels::Line>& X) const {
  kernels_.project(data(problem_.blocks()), blocks_, static_cast<int>(problem_.parameters()), U.data(),
                   data(X));
}

void Design::add_products(const std::vector<kernels::Line>& X, const std::vector<kernels::Line>& Y,
                          double factor, std::vector<kernels::Line>& S) const {
  kernels_.add_products(data(X), data(Y), factor, blocks_, data(S));
}

PredictedError predicted_error(const DesignProblem& problem, const Eigen::MatrixXd& covariance) {
  const Eigen::MatrixXd& J = problem.task_rows();
  const Eigen::VectorXd variance = (J * covariance).cwiseProduct(J).rowwise().sum();
  PredictedError error;
  for (Eigen::Index i = 0; i < variance.size(); i += 3) {
    error.rms_mm += variance.segment<3>(i).sum();
    error.max_mm = std::max(error.max_mm, std::sqrt(variance.segment<3>(i).sum()));
  }
  error.rms_mm = std::sqrt(error.rms_mm * 3 / static_cast<double>(variance.size()));
  return error;
}

PredictedError predicted_error(const DesignProblem& problem, std::span<const std::size_t> chosen) {
  return predicted_error(problem, inverse(information(problem, chosen)));
}

}  // namespace truepose
