#include "tools/report/local_regression.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "core/math/statistics.hpp"

namespace truepose::report {
namespace {

using Points = std::vector<std::pair<double, double>>;

constexpr std::size_t kFewestPoints = 5;
constexpr int kPasses = 4;  // after the first, each with the weights that the one before gave the points
// Part of the weight that pulls a slope to zero where the points within the bandwidth hardly tell it.
constexpr double kSlopePull = 0.02;

double value_at(double x0, const Points& points, const std::vector<double>& trust, double bandwidth) {
  double w = 1e-12, wx = 0, wy = 0, wxx = 0, wxy = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const double dx = (points[i].first - x0) / bandwidth, y = points[i].second;
    const double weight = trust[i] * std::exp(-dx * dx / 2);
    w += weight;
    wx += weight * dx;
    wy += weight * y;
    wxx += weight * dx * dx;
    wxy += weight * dx * y;
  }
  const double x_mean = wx / w, y_mean = wy / w;
  const double slope = (wxy - w * x_mean * y_mean) / (wxx - w * x_mean * x_mean + kSlopePull * w);
  return y_mean - slope * x_mean;
}

double interpolated(const Points& curve, double x) {
  const double step = curve[1].first - curve[0].first;
  const auto k = static_cast<std::size_t>(
      std::clamp((x - curve[0].first) / step, 0.0, static_cast<double>(curve.size()) - 2));
  return std::lerp(curve[k].second, curve[k + 1].second, (x - curve[k].first) / step);
}

/// Tukey's bisquare of the distance from the curve, zero from six of the median distance on.
std::vector<double> trust_in(const Points& points, const Points& curve) {
  std::vector<double> distances;
  for (const auto& [x, y] : points) distances.push_back(std::abs(y - interpolated(curve, x)));
  const double reach = std::max(6 * median(distances), 1e-12);
  for (double& d : distances) d = d < reach ? std::pow(1 - d * d / (reach * reach), 2) : 0;
  return distances;
}

}  // namespace

Points local_regression(const Points& points, double bandwidth, int samples) {
  if (points.size() < kFewestPoints) return {};
  const auto [first, last] = std::ranges::minmax(points, {}, &std::pair<double, double>::first);
  const double from = first.first, to = last.first;
  if (!(to > from)) return {};
  std::vector<double> trust(points.size(), 1);
  Points curve;
  for (int pass = 0; pass < kPasses; ++pass) {
    curve.clear();
    for (int k = 0; k < samples; ++k) {
      const double x = from + k * (to - from) / (samples - 1);
      curve.emplace_back(x, value_at(x, points, trust, bandwidth));
    }
    trust = trust_in(points, curve);
  }
  return curve;
}

}  // namespace truepose::report
