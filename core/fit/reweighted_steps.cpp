#include "core/fit/reweighted_steps.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/data/calibrated_cell.hpp"
#include "core/fit/least_squares_solver.hpp"
#include "core/fit/target_turns.hpp"
#include "core/fit/whole_steps.hpp"

namespace truepose {
namespace {

std::vector<Eigen::Matrix3d> reweighted(std::span<const Eigen::Matrix3d> W, std::span<const double> weights) {
  std::vector<Eigen::Matrix3d> out(W.begin(), W.end());
  out.resize(weights.size(), Eigen::Matrix3d::Identity());
  for (std::size_t i = 0; i < weights.size(); ++i) out[i] *= std::sqrt(weights[i]);
  return out;
}

PreparedPoints prepared(const CalibratedCell& cell, const LeastSquaresProblem& problem) {
  return {cell.robot, problem.points, ParameterLayout::of(cell).reflectors, problem.W};
}

}  // namespace

std::vector<double> whitened_lengths(const Eigen::VectorXd& residuals, std::span<const Eigen::Matrix3d> W) {
  std::vector<double> lengths(static_cast<std::size_t>(residuals.size() / 3));
  for (std::size_t i = 0; i < lengths.size(); ++i) {
    const Eigen::Vector3d r = residuals.segment<3>(3 * static_cast<Eigen::Index>(i));
    lengths[i] = (W.empty() ? r : Eigen::Vector3d{W[i] * r}).norm();
  }
  return lengths;
}

std::vector<double> whitened_lengths(const Eigen::VectorXd& residuals, const CalibratedCell& cell,
                                     const LeastSquaresProblem& whitened, std::span<const double> weights) {
  std::vector<double> lengths = whitened_lengths(residuals, whitened.W);
  const std::vector<double> turns = whitened_turns(cell, whitened.points, whitened.turn_weight, weights);
  for (std::size_t i = 0; i < lengths.size(); ++i) lengths[i] = std::max(lengths[i], turns[i]);
  return lengths;
}

ReweightedSteps::ReweightedSteps(CalibratedCell start, const LeastSquaresProblem& problem)
    : cell_{std::move(start)},
      whitened_{problem},
      weighted_{problem},
      weights_(problem.points.size(), 1.0),
      residuals_(cell_.robot, problem.points),
      points_{prepared(cell_, problem)},
      lengths_mm_{lengths_at(cell_)} {}

std::vector<double> ReweightedSteps::lengths_at(const CalibratedCell& cell) const {
  return whitened_lengths(residuals_.at(cell), cell, whitened_, weights_);
}

void ReweightedSteps::step(std::span<const double> weights, const Prior& prior) {
  weights_.assign(weights.begin(), weights.end());
  weighted_.W = reweighted(whitened_.W, weights);
  for (std::size_t i = 0; i < weighted_.turn_weight.size(); ++i)
    weighted_.turn_weight[i] = whitened_.turn_weight[i] * std::sqrt(weights[i]);
  weighted_.prior = prior;
  if (step_whole(weights)) return;
  cell_ = gauss_newton_by(StepSolver::Orthogonal, cell_, weighted_, {.max_iterations = 1})->cell;
  lengths_mm_ = lengths_at(cell_);
}

/// False, and nothing is moved, where the step is not possible or does not descend.
bool ReweightedSteps::step_whole(std::span<const double> weights) {
  if (!WholeSteps::possible(cell_, weighted_)) return false;
  if (bases_follow_links(cell_.robot)) {
    points_ = prepared(cell_, weighted_);
  } else {
    points_.reweight(weighted_.W);
  }
  WholeSteps whole(cell_, points_, weighted_);
  whole.evaluate(cell_);
  CalibratedCell next = cell_;
  const auto change = whole.advance(next);
  if (!change) return false;
  std::vector<double> lengths_mm = lengths_at(next);
  if (!ends_fit(*change, whole.rms_mm()) && !descends(whole.rms_mm(), rms_mm(lengths_mm, weights, next)))
    return false;
  cell_ = std::move(next);
  lengths_mm_ = std::move(lengths_mm);
  return true;
}

/// What the normal equations would say, by the lengths that the next step needs anyway.
double ReweightedSteps::rms_mm(std::span<const double> lengths_mm, std::span<const double> weights,
                               const CalibratedCell& cell) const {
  double cost = 0;
  for (std::size_t i = 0; i < weights.size(); ++i) cost += weights[i] * lengths_mm[i] * lengths_mm[i];
  const Prior& prior = weighted_.prior;
  if (prior.weight.size() > 0) {
    const Eigen::VectorXd values = parameter_values(cell);
    for (const int k : weighted_.free) {
      const double off = prior.weight[k] * (values[k] - prior.centre[k]);
      cost += off * off;
    }
  }
  return std::sqrt(cost / static_cast<double>(weights.size()));
}

}  // namespace truepose
