#include "core/fit/robust_fit.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

#include "core/data/calibrated_cell.hpp"
#include "core/fit/measurement_model.hpp"
#include "core/fit/placement.hpp"
#include "core/fit/prior.hpp"
#include "core/fit/reweighted_steps.hpp"
#include "core/math/random.hpp"
#include "core/math/statistics.hpp"

namespace truepose {

double huber_weight(double length, double knee) { return length <= knee ? 1.0 : knee / length; }

double igg3_weight(double length, double knee, double cut) {
  if (length <= knee) return 1.0;
  if (length >= cut) return 0.0;
  const double left = (cut - length) / (cut - knee);
  return knee / length * left * left;
}

double tukey_weight(double length, double cut) {
  if (length >= cut) return 0.0;
  const double left = 1 - length * length / (cut * cut);
  return left * left;
}

double sigma_from_median(std::span<const double> lengths) {
  constexpr double kMedianOfChi3 = 1.5381722544550522;
  return median({lengths.begin(), lengths.end()}) / kMedianOfChi3;
}

namespace {

constexpr double kHuberKnee = 2.5, kTukeyCut = 6, kRejectBeyond = 5;
constexpr double kIgg3Knee = 3, kIgg3Cut = 6;
constexpr int kSubsets = 40, kSubsetSize = 8;
constexpr double kFewestEffectivePoints = 12;
// Wide enough for any arm that is not broken: it only keeps weak directions from running away.
constexpr PriorScale kWide{.length_mm = 3, .angle_rad = 15e-3, .deviation = 15e-3};

/// A subset with a point of every reflector, so that none is left without an equation.
std::vector<Measurement> random_subset(std::span<const Measurement> points, std::size_t reflectors,
                                       Random& random) {
  std::vector<std::size_t> order(points.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  for (std::size_t i = order.size(); i-- > 1;) std::swap(order[i], order[random.next() % (i + 1)]);
  const std::size_t wanted = kSubsetSize + 4 * (reflectors - 1);
  std::vector<std::size_t> taken(reflectors, 0);
  std::vector<Measurement> subset;
  for (const std::size_t i : order) {
    const auto smr = static_cast<std::size_t>(points[i].smr);
    if (subset.size() >= wanted && taken[smr] > 1) continue;
    ++taken[smr];
    subset.push_back(points[i]);
    if (subset.size() >= wanted && std::ranges::min(taken) > 1) break;
  }
  return subset;
}

/// Weights of a step of the chain. The scale grows until enough points carry it.
template <typename Weight>
std::vector<double> carried_weights(std::span<const double> lengths, double sigma, const Weight& weight) {
  const double fewest = std::min(kFewestEffectivePoints, static_cast<double>(lengths.size()));
  std::vector<double> weights(lengths.size());
  for (;; sigma *= 1.5) {
    std::ranges::transform(lengths, weights.begin(), [&](double l) { return weight(l / sigma); });
    if (std::accumulate(weights.begin(), weights.end(), 0.0) >= fewest || !(sigma < 1e9)) return weights;
  }
}

double huber(double u) { return huber_weight(u, kHuberKnee); }
double tukey(double u) { return tukey_weight(u, kTukeyCut); }

double positive(double sigma) { return std::max(sigma, 1e-12); }

}  // namespace

CalibratedCell robust_start(const RobotModel& arm, std::span<const std::string> smr_names,
                            std::span<const Measurement> points, std::span<const Eigen::Matrix3d> W) {
  const RepeatedResiduals errors(arm, points);
  const auto middle = [&](const CalibratedCell& cell) {
    return median(whitened_lengths(errors.at(cell), W));
  };
  CalibratedCell best = placement(arm, smr_names, points);
  double best_median = middle(best);
  Random random(0);
  for (int i = 0; i < kSubsets; ++i) {
    const std::vector<Measurement> subset = random_subset(points, smr_names.size(), random);
    const CalibratedCell candidate = placement(arm, smr_names, subset);
    const double candidate_median = middle(candidate);
    if (candidate_median < best_median) {
      best = candidate;
      best_median = candidate_median;
    }
  }

  const ParameterLayout layout = ParameterLayout::of(best);
  LeastSquaresProblem problem{
      .points = points, .free = {}, .W = {W.begin(), W.end()}, .prior = placement_prior(layout)};
  problem.free.resize(static_cast<std::size_t>(layout.link(0)));
  std::iota(problem.free.begin(), problem.free.end(), 0);
  ReweightedSteps steps(std::move(best), problem);
  for (int i = 0; i < 9; ++i) {
    const std::vector<double>& lengths = steps.lengths_mm();
    const double sigma = positive(sigma_from_median(lengths));
    const std::vector<double> weights =
        i < 3 ? carried_weights(lengths, sigma, huber) : carried_weights(lengths, sigma, tukey);
    steps.step(weights, problem.prior);
  }
  return steps.cell();
}

RobustFit robust_fit(const CalibratedCell& start, const LeastSquaresProblem& problem) {
  const auto equations = 3.0 * static_cast<double>(problem.points.size());
  const double freedom = std::max(0.1, 1 - static_cast<double>(problem.free.size()) / equations);
  ReweightedSteps steps(start, problem);
  const std::vector<double>& lengths = steps.lengths_mm();
  double sigma_mm = 0;
  for (int i = 0; i < 18; ++i) {
    if (i < 5) sigma_mm = positive(sigma_from_median(lengths) / std::sqrt(freedom));
    const std::vector<double> weights =
        i < 10 ? carried_weights(lengths, sigma_mm, huber) : carried_weights(lengths, sigma_mm, tukey);
    steps.step(weights, prior_of(start, kWide, sigma_mm));
  }
  return {steps.cell(), positive(sigma_from_median(lengths) / std::sqrt(freedom))};
}

std::vector<double> point_weights(const CalibratedCell& cell, const LeastSquaresProblem& whitened,
                                  std::span<const double> present, Loss loss, double sigma_mm) {
  std::vector<double> weights = whitened_lengths(residuals(cell, whitened.points), cell, whitened, present);
  for (double& weight : weights) {
    const double u = weight / sigma_mm;
    switch (loss) {
      case Loss::OutlierRejection:
      case Loss::Squared:
        weight = 1;
        break;
      case Loss::Huber:
        weight = huber_weight(u, kHuberKnee);
        break;
      case Loss::Igg3:
        weight = igg3_weight(u, kIgg3Knee, kIgg3Cut);
        break;
      case Loss::Tukey:
        weight = u <= kRejectBeyond ? 1 : 0;
        break;
    }
  }
  return weights;
}

}  // namespace truepose
