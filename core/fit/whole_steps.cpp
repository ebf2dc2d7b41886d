#include "core/fit/whole_steps.hpp"

#include <algorithm>
#include <cmath>

#include "core/data/calibrated_cell.hpp"

namespace truepose {
namespace {

/// Squared pivots at unit column norm below this mean columns so dependent (condition above about 1e5) that
/// the normal equations lose digits that the fit needs.
constexpr double kSmallestPivot = 1e-10;

}  // namespace

WholeSteps::WholeSteps(const CalibratedCell& start, PreparedPoints& points,
                       const LeastSquaresProblem& problem)
    : points_{points},
      free_{problem.free},
      equations_(start, points, problem.free, problem.prior),
      size_{static_cast<int>(problem.free.size())},
      stride_{(size_ + kernels::kMostLanes) / kernels::kMostLanes * kernels::kMostLanes},
      lines_(static_cast<std::size_t>(size_ * stride_ / kernels::kMostLanes + 1)),
      scale_(size_),
      step_(size_),
      direction_{Eigen::VectorXd::Zero(ParameterLayout::of(start).size())} {}

bool WholeSteps::possible(const CalibratedCell& start, const LeastSquaresProblem& problem) {
  if (!problem.turn_weight.empty()) return false;  // the kernels know positions
  const int first_link = ParameterLayout::of(start).link(0);
  return std::ranges::count_if(problem.free, [=](int parameter) { return parameter >= first_link; }) <=
         NormalEquations::kMostLinkParameters;
}

void WholeSteps::evaluate(const CalibratedCell& cell) { equations_.evaluate(cell); }

double WholeSteps::rms_mm() const { return std::sqrt(equations_.cost() / points_.size()); }

/// J'WJ step = -J'Wf; false where that would lose digits.
bool WholeSteps::solve() {
  for (int i = 0; i < size_; ++i) scale_[i] = 1 / std::sqrt(equations_.product(i, i));
  double* const A = lines_[0].value;
  for (int i = 0; i < size_; ++i) {
    double* const column = A + i * stride_;
    for (int j = i; j < size_; ++j) column[j] = equations_.product(i, j) * scale_[i] * scale_[j];
    column[size_] = -equations_.gradient(i) * scale_[i];
  }
  // Written so that a NaN, of a column of zeros, fails.
  if (!(points_.code().solve_positive(A, stride_, size_, step_.data()) > kSmallestPivot)) return false;
  step_.array() *= scale_.array();
  return true;
}

std::optional<double> WholeSteps::advance(CalibratedCell& cell) {
  if (!solve()) return std::nullopt;
  double promised = 0;  // |J step|^2, by which the cost decreases, mm^2
  for (int i = 0; i < size_; ++i) promised -= equations_.gradient(i) * step_[i];
  const double change = std::sqrt(promised / points_.size());
  if (!std::isfinite(change)) return std::nullopt;
  for (std::size_t k = 0; k < free_.size(); ++k) direction_[free_[k]] = step_[static_cast<Eigen::Index>(k)];
  move_by(cell, direction_);
  return change;
}

bool descends(double before_mm, double after_mm) {
  // The coordinates of a predicted point are not known better than this (mm).
  constexpr double kCoordinateRounding_mm = 1e-10;
  // Written so that a NaN fails.
  return after_mm <= before_mm + kCoordinateRounding_mm;
}

}  // namespace truepose
