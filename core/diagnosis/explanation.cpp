#include "core/diagnosis/explanation.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/fit/least_squares_solver.hpp"
#include "core/fit/measurement_model.hpp"
#include "core/fit/placement.hpp"
#include "core/math/statistics.hpp"

namespace truepose {
namespace {

constexpr std::size_t kFewestPointsToTrim = 20;
constexpr double kTrustedUpTo = 5;  // times the median miss
constexpr double kReading_mm = 0.1;
constexpr double kGrossSigmas = 5;

using Points = std::vector<Measurement>;
using Names = std::span<const std::string>;

/// The three quarters of the points that `cell` misses least.
Points nearest(const CalibratedCell& cell, const Points& points) {
  if (points.size() < kFewestPointsToTrim) return points;
  const std::vector<double> miss_mm = misses(cell, points);
  std::vector<std::size_t> order(points.size());
  std::iota(order.begin(), order.end(), 0);
  std::ranges::sort(order, {}, [&](std::size_t k) { return miss_mm[k]; });
  Points kept;
  for (std::size_t k = 0; k < points.size() * 3 / 4; ++k) kept.push_back(points[order[k]]);
  return kept;
}

/// The points that `cell` does not miss many times as far as the middle one.
Points trusted(const CalibratedCell& cell, const Points& points) {
  const std::vector<double> miss_mm = misses(cell, points);
  const double most_mm = kTrustedUpTo * median(miss_mm);
  Points kept;
  for (std::size_t k = 0; k < points.size(); ++k) {
    if (miss_mm[k] <= most_mm) kept.push_back(points[k]);
  }
  return kept;
}

bool is_length(int parameter) {
  const int entry = parameter % ParameterLayout::kLink;  // a, alpha, d, theta, beta
  return entry == 0 || entry == 2;
}

/// Hardly holds reflectors to the flange and what is open to where it is: enough that a fit does not run away
/// where the points do not tell it, as a reflector right on an axis.
Prior loose_prior(const CalibratedCell& start, const std::vector<int>& open) {
  constexpr double kPerLength = 1e-3, kPerAngle = 1;  // mm of residual
  const ParameterLayout layout = ParameterLayout::of(start);
  Prior prior{.centre = parameter_values(start), .weight = Eigen::VectorXd::Zero(layout.size())};
  const int coordinates = ParameterLayout::kReflector * layout.reflectors;
  prior.centre.segment(layout.reflector(0), coordinates).setZero();
  prior.weight.segment(layout.reflector(0), coordinates).setConstant(kPerLength);
  for (const int parameter : open)
    prior.weight[layout.link(0) + parameter] = is_length(parameter) ? kPerLength : kPerAngle;
  return prior;
}

/// A placement with what is open fitted too.
CalibratedCell with_open(const CalibratedCell& start, const Points& points, const std::vector<int>& open,
                         int iterations) {
  if (open.empty()) return start;
  const ParameterLayout layout = ParameterLayout::of(start);
  std::vector<int> free = first_parameters(layout.link(0));
  for (const int parameter : open) free.push_back(layout.link(0) + parameter);
  std::ranges::sort(free);
  const LeastSquaresProblem problem{
      .points = points, .free = std::move(free), .W = {}, .prior = loose_prior(start, open)};
  return gauss_newton(start, problem, {.max_iterations = iterations, .tolerance_mm = 1e-3}).cell;
}

/// What is known of the links of a case before they are fitted.
Prior link_prior(const ModelAndPoints& given, const CalibratedCell& start) {
  CalibratedCell centre = start;
  centre.robot = given.arm;
  Prior prior = loose_prior(centre, given.open);
  const int first = ParameterLayout::of(start).link(0);
  for (int parameter = 0; parameter < ParameterLayout::kLink * given.arm.joint_count(); ++parameter) {
    if (std::ranges::find(given.open, parameter) == given.open.end())
      prior.weight[first + parameter] = kReading_mm / usual_deviation(parameter);
  }
  return prior;
}

CalibratedCell fitted_links(const CalibratedCell& start, const Prior& prior, const Points& points) {
  constexpr int kIterations = 100;  // where the flange hardly turns; else a few
  const LeastSquaresProblem problem{.points = points,
                                    .free = first_parameters(ParameterLayout::of(start).deviation(0)),
                                    .W = {},
                                    .prior = prior};
  return gauss_newton(start, problem, {.max_iterations = kIterations, .tolerance_mm = 1e-4}).cell;
}

/// Fitted to the points that are trusted, until these are known to the misses that are left.
CalibratedCell settled(const CalibratedCell& start, const Prior& prior, const Points& points) {
  constexpr int kRounds = 6;
  CalibratedCell cell = fitted_links(start, prior, nearest(start, points));
  double before_mm = median(misses(cell, points));
  for (int round = 0; round < kRounds; ++round) {
    cell = fitted_links(cell, prior, trusted(cell, points));
    const double after_mm = median(misses(cell, points));
    if (after_mm > 0.9 * before_mm) break;
    before_mm = after_mm;
  }
  return cell;
}

}  // namespace

double Explanation::error_mm() const { return median(miss_mm); }

double Explanation::misfit(double sigma_mm) const {
  double sum = 0;
  for (const double miss : miss_mm) {
    const double sigmas = std::min(miss / sigma_mm, kGrossSigmas);
    sum += sigmas * sigmas;
  }
  return sum;
}

double Explanation::share_missed() const {
  const double most_mm = kTrustedUpTo * error_mm();
  const auto missed = std::ranges::count_if(miss_mm, [&](double miss) { return miss > most_mm; });
  return static_cast<double>(missed) / static_cast<double>(miss_mm.size());
}

std::vector<double> misses(const CalibratedCell& cell, std::span<const Measurement> points) {
  const Eigen::VectorXd f = residuals(cell, points);
  std::vector<double> miss_mm;
  for (Eigen::Index row = 0; row < f.size(); row += 3) miss_mm.push_back(f.segment<3>(row).norm());
  return miss_mm;
}

std::vector<double> distances_from_middle(std::span<const Measurement> points) {
  Eigen::Vector3d middle;
  for (const int axis : {0, 1, 2}) {
    std::vector<double> values;
    for (const Measurement& point : points) values.push_back(point.p_WS_mm[axis]);
    middle[axis] = median(std::move(values));
  }
  std::vector<double> distances;
  for (const Measurement& point : points) distances.push_back((point.p_WS_mm - middle).norm());
  return distances;
}

double rough_error(const ModelAndPoints& given, Names names) {
  constexpr int kIterations = 6;
  const CalibratedCell cell = placement(given.arm, names, given.points, PlacementSearch::Near);
  return median(misses(with_open(cell, given.points, given.open, kIterations), given.points));
}

CalibratedCell placed(const ModelAndPoints& given, Names names) {
  constexpr int kIterations = 20;
  const Points better = nearest(placement(given.arm, names, given.points), given.points);
  return with_open(placement(given.arm, names, better), better, given.open, kIterations);
}

double usual_deviation(int parameter) { return is_length(parameter) ? 3 : 0.015; }

Explanation explanation(const ModelAndPoints& given, const CalibratedCell& start) {
  const Prior prior = link_prior(given, start);
  Explanation result{.cell = settled(start, prior, given.points),
                     .coarse_mm = median(misses(start, given.points))};
  result.miss_mm = misses(result.cell, given.points);
  const Eigen::VectorXd off = parameter_values(result.cell) - prior.centre;
  const int first = ParameterLayout::of(start).link(0);
  for (int parameter = 0; parameter < ParameterLayout::kLink * given.arm.joint_count(); ++parameter) {
    if (std::ranges::find(given.open, parameter) != given.open.end()) continue;
    const double sigmas = std::abs(off[first + parameter]) / usual_deviation(parameter);
    result.deviation += sigmas * sigmas;
    result.largest_deviation = std::max(result.largest_deviation, sigmas);
  }
  return result;
}

}  // namespace truepose
