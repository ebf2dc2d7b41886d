#include "core/calibration/weighted_points.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/calibration/robust_fit.hpp"

namespace truepose {

WeightedPoints::WeightedPoints(std::vector<Measurement> points, const std::optional<MeasurementNoise>& noise)
    : points_{std::move(points)}, whitening_{whitening_of(points_, noise).W}, weights_(points_.size(), 1.0) {}

int WeightedPoints::equations() const {
  return 3 * static_cast<int>(std::ranges::count_if(weights_, [](double w) { return w > 0; }));
}

std::vector<Measurement> WeightedPoints::trusted() const {
  std::vector<Measurement> trusted;
  for (std::size_t i = 0; i < points_.size(); ++i) {
    if (weights_[i] > 0) trusted.push_back(points_[i]);
  }
  return trusted;
}

double WeightedPoints::whitened_length(std::size_t point, const Eigen::Vector3d& error_mm) const {
  return whitening_.empty() ? error_mm.norm() : (whitening_[point] * error_mm).norm();
}

LeastSquaresProblem WeightedPoints::problem(std::vector<int> free) const {
  return {.points = points_, .free = std::move(free), .W = weighted_whitening(), .prior = {}};
}

std::vector<Eigen::Matrix3d> WeightedPoints::weighted_whitening() const {
  std::vector<Eigen::Matrix3d> W = whitening_;
  W.resize(points_.size(), Eigen::Matrix3d::Identity());
  for (std::size_t i = 0; i < W.size(); ++i) W[i] *= std::sqrt(weights_[i]);
  return W;
}

bool WeightedPoints::weigh(const CalibratedCell& cell, Loss loss, double sigma_mm) {
  constexpr double kSame = 1e-6;
  sigma_mm_ = sigma_mm;
  std::vector<double> weights = point_weights(cell, points_, whitening_, loss, sigma_mm);
  if (std::ranges::equal(weights, weights_, [](double a, double b) { return std::abs(a - b) < kSame; }))
    return false;
  weights_ = std::move(weights);
  return true;
}

}  // namespace truepose
