#include "core/fit/weighted_points.hpp"

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include "core/fit/robust_fit.hpp"
#include "core/fit/target_turns.hpp"

namespace truepose {
namespace {

template <typename T>
std::vector<T> those_trusted(const std::vector<T>& all, const std::vector<bool>& trusted) {
  std::vector<T> some;
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (trusted[i]) some.push_back(all[i]);
  }
  return some;
}

}  // namespace

WeightedPoints::WeightedPoints(std::vector<Measurement> points, const std::optional<MeasurementNoise>& noise)
    : points_{std::move(points)}, weights_(points_.size(), 1.0), trusted_(points_.size(), true) {
  Whitening whitening = whitening_of(points_, noise);
  whitening_ = std::move(whitening.W);
  stated_sigma_mm_ = whitening.finest_mm;
  turns_ = turn_weights(points_, stated_sigma_mm_);
}

int WeightedPoints::rows() const {
  int rows = 0;
  for (std::size_t i = 0; i < points_.size(); ++i)
    if (trusted_[i]) rows += points_[i].orientation ? 6 : 3;
  return rows;
}

int WeightedPoints::equations() const {
  std::set<int> mounted;
  for (std::size_t i = 0; i < points_.size(); ++i)
    if (trusted_[i] && points_[i].orientation) mounted.insert(points_[i].smr);
  return rows() - 3 * static_cast<int>(mounted.size());
}

std::vector<Measurement> WeightedPoints::trusted_points() const { return those_trusted(points_, trusted_); }

double WeightedPoints::whitened_length(std::size_t point, const Eigen::Vector3d& error_mm) const {
  return whitening_.empty() ? error_mm.norm() : (whitening_[point] * error_mm).norm();
}

LeastSquaresProblem WeightedPoints::problem(std::vector<int> free) const {
  return {.points = points_,
          .free = std::move(free),
          .W = weighted_whitening(),
          .turn_weight = weighted_turns(),
          .prior = {}};
}

void WeightedPoints::weigh(LeastSquaresProblem& problem) const {
  problem.W = weighted_whitening();
  problem.turn_weight = weighted_turns();
}

std::vector<double> WeightedPoints::weighted_turns() const {
  std::vector<double> weighted = turns_;
  for (std::size_t i = 0; i < weighted.size(); ++i) weighted[i] *= std::sqrt(weights_[i]);
  return weighted;
}

std::vector<double> WeightedPoints::trusted_turns() const {
  return turns_.empty() ? turns_ : those_trusted(weighted_turns(), trusted_);
}

std::vector<Eigen::Matrix3d> WeightedPoints::weighted_whitening() const {
  if (whitening_.empty() && std::ranges::count(weights_, 1.0) == std::ssize(weights_)) return {};
  std::vector<Eigen::Matrix3d> W = whitening_;
  W.resize(points_.size(), Eigen::Matrix3d::Identity());
  for (std::size_t i = 0; i < W.size(); ++i) W[i] *= std::sqrt(weights_[i]);
  return W;
}

std::vector<Eigen::Matrix3d> WeightedPoints::trusted_whitening() const {
  return those_trusted(weighted_whitening(), trusted_);
}

bool WeightedPoints::weigh(const CalibratedCell& cell, Loss loss, double sigma_mm) {
  constexpr double kSame = 1e-6;
  sigma_mm_ = sigma_mm;
  // Huber's weights are never zero: Tukey's limit decides which of its points are outliers.
  const Loss judge = loss == Loss::Huber ? Loss::Tukey : loss;
  const LeastSquaresProblem whitened{
      .points = points_, .free = {}, .W = whitening_, .turn_weight = turns_, .prior = {}};
  const std::vector<double> judged = point_weights(cell, whitened, weights_, judge, sigma_mm);
  for (std::size_t i = 0; i < judged.size(); ++i) trusted_[i] = judged[i] > 0;
  std::vector<double> weights =
      loss == judge ? judged : point_weights(cell, whitened, weights_, loss, sigma_mm);
  if (std::ranges::equal(weights, weights_, [](double a, double b) { return std::abs(a - b) < kSame; }))
    return false;
  weights_ = std::move(weights);
  return true;
}

}  // namespace truepose
