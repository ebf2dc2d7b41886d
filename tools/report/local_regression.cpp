#include "tools/report/local_regression.hpp"

#include <algorithm>
#include <cmath>

namespace truepose::report {
namespace {

constexpr std::size_t kFewestPoints = 5;
// Part of the weight that pulls a slope to zero where the points within the bandwidth hardly tell it.
constexpr double kSlopePull = 0.1;

double value_at(double x0, const std::vector<std::pair<double, double>>& points, double bandwidth) {
  double w = 0, wx = 0, wy = 0, wxx = 0, wxy = 0;
  for (const auto& [x, y] : points) {
    const double dx = (x - x0) / bandwidth;
    const double weight = std::exp(-dx * dx / 2);
    w += weight;
    wx += weight * dx;
    wy += weight * y;
    wxx += weight * dx * dx;
    wxy += weight * dx * y;
  }
  if (!(w > 0)) return 0;
  const double x_mean = wx / w, y_mean = wy / w;
  const double slope = (wxy - w * x_mean * y_mean) / (wxx - w * x_mean * x_mean + kSlopePull * w);
  return y_mean - slope * x_mean;
}

}  // namespace

std::vector<std::pair<double, double>> local_regression(const std::vector<std::pair<double, double>>& points,
                                                        double bandwidth, int samples) {
  if (points.size() < kFewestPoints) return {};
  const auto [first, last] = std::ranges::minmax(points, {}, &std::pair<double, double>::first);
  const double from = first.first, to = last.first;
  if (!(to > from)) return {};
  std::vector<std::pair<double, double>> curve;
  for (int k = 0; k < samples; ++k) {
    const double x = from + k * (to - from) / (samples - 1);
    curve.emplace_back(x, value_at(x, points, bandwidth));
  }
  return curve;
}

}  // namespace truepose::report
