#include "core/identify/model_sanity.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/identify/calibrated_cell.hpp"
#include "core/identify/least_squares_solver.hpp"
#include "core/identify/linear_start.hpp"
#include "core/identify/measurement_model.hpp"
#include "core/identify/mistakes.hpp"
#include "core/identify/reflector_labels.hpp"
#include "core/math/statistics.hpp"

namespace truepose {
namespace {

constexpr double kDeviates_mm = 5;   // up to here an arm may merely deviate
constexpr double kCannotBe_mm = 50;  // from here it cannot be right, whatever the reason
// How many times better one mistake, and several, have to explain the points. Right arms with the paper's
// errors, and three times those, gain at most 1.4 and 2.4.
constexpr double kBetter = 2;
constexpr double kBetterOfSeveral = 5;
constexpr std::size_t kPosesToJudge = 8;       // with fewer, chance and a failed fit explain as much
constexpr double kAsGood = 1.5;                // times: explanations that leave so much more are as good
constexpr std::size_t kPoses = 40;             // tell a gross mistake as well as more would
constexpr std::size_t kPosesToIdentify = 150;  // tell a hidden one
constexpr std::size_t kShortlist = 8;          // explanations fitted to the end
constexpr std::size_t kFewestPointsToTrim = 20;
// A reflector near an axis hardly shows which way its joint turns: there the identified arms are compared.
constexpr std::size_t kFewestPointsToIdentify = 20;
constexpr int kIdentifyIterations = 10;
constexpr double kBetterIdentified = 1.3;
constexpr double kExplained = 0.1;  // what is left of the error once the links are identified
constexpr double kShows_mm = 0.05;  // more than bearings and gears leave at random

using Points = std::vector<Measurement>;

/// All points of at most so many poses, spread evenly over the data.
Points sampled(const MeasurementData& data, std::size_t most_poses) {
  const auto groups = pose_groups(data.points);
  const std::size_t count = std::min(groups.size(), most_poses);
  Points points;
  for (std::size_t k = 0; k < count; ++k) {
    for (const std::size_t i : groups[k * groups.size() / count]) points.push_back(data.points[i]);
  }
  return points;
}

std::vector<double> misses(const CalibratedCell& cell, std::span<const Measurement> points) {
  const Eigen::VectorXd f = residuals(cell, points);
  std::vector<double> miss_mm;
  for (Eigen::Index row = 0; row < f.size(); row += 3) miss_mm.push_back(f.segment<3>(row).norm());
  return miss_mm;
}

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

/// An arm and the points it is to explain, with or without a mistake mended.
struct Hypothesis {
  std::string what;
  RobotModel arm;
  Points points;
  double error_mm = 0;
};

using Names = std::span<const std::string>;

double rough_error(const Hypothesis& guess, Names names) {
  return median(misses(linear_start(guess.arm, names, guess.points), guess.points));
}

std::vector<int> first_parameters(int count) {
  std::vector<int> indices(static_cast<std::size_t>(count));
  std::iota(indices.begin(), indices.end(), 0);
  return indices;
}

/// Base and reflectors fitted to the end, from the better part of the points, so that a few gross errors do
/// not speak against the arm.
CalibratedCell placed(const Hypothesis& guess, Names names) {
  const Points trusted = nearest(linear_start(guess.arm, names, guess.points), guess.points);
  const CalibratedCell start = linear_start(guess.arm, names, trusted);
  const auto base_and_reflectors = first_parameters(ParameterLayout::of(start).link(0));
  const LeastSquaresProblem problem{.points = trusted, .free = base_and_reflectors, .W = {}, .prior = {}};
  return gauss_newton(start, problem, {.max_iterations = 20}).cell;
}

double fitted_error(const Hypothesis& guess, Names names) {
  return median(misses(placed(guess, names), guess.points));
}

/// Standard deviations that hold the links to where they are; base and reflectors hardly. Without them a fit
/// diverges where a reflector is right on an axis.
Eigen::VectorXd link_sigmas(const ParameterLayout& layout) {
  constexpr double kLinkLength_mm = 3, kLinkAngle_rad = 0.015, kHardly = 1000;
  Eigen::VectorXd sigma = Eigen::VectorXd::Constant(layout.size(), kHardly);
  for (int i = 0; i < layout.joints; ++i) {
    sigma.segment<5>(layout.link(i)) << kLinkLength_mm, kLinkAngle_rad, kLinkLength_mm, kLinkAngle_rad,
        kLinkAngle_rad;
  }
  return sigma;
}

/// The links identified too, from where base and reflectors were placed.
CalibratedCell identified(const Hypothesis& guess, const CalibratedCell& placed) {
  constexpr double kReading_mm = 0.1;
  const ParameterLayout layout = ParameterLayout::of(placed);
  const LeastSquaresProblem problem{
      .points = guess.points,
      .free = first_parameters(layout.deviation(0)),
      .W = {},
      .prior = {.centre = parameter_values(placed),
                .weight = (kReading_mm * link_sigmas(layout).cwiseInverse()).eval()}};
  return gauss_newton(placed, problem, {.max_iterations = kIdentifyIterations}).cell;
}

/// What the arm leaves with its links identified too.
double identified_error(const Hypothesis& guess, Names names) {
  return median(misses(identified(guess, placed(guess, names)), guess.points));
}

/// Whether the links need only be off by what arms are off by to explain the points: then no mistake does it
/// better.
bool merely_deviates(const Hypothesis& as_given, Names names) {
  constexpr double kMostSigmas = 3;
  const CalibratedCell start = placed(as_given, names);
  const CalibratedCell cell = identified(as_given, start);
  const ParameterLayout layout = ParameterLayout::of(cell);
  const int links = layout.link(layout.joints) - layout.link(0);
  const Eigen::VectorXd off = (parameter_values(cell) - parameter_values(start))
                                  .cwiseQuotient(link_sigmas(layout))
                                  .segment(layout.link(0), links);
  return off.cwiseAbs().maxCoeff() < kMostSigmas &&
         median(misses(cell, as_given.points)) < kExplained * as_given.error_mm;
}

Hypothesis mended(const Hypothesis& as_given, const Mistake& mistake) {
  Hypothesis guess = as_given;
  guess.what = mistake.what;
  mistake.mend(guess.arm, guess.points);
  return guess;
}

/// The most promising mistakes, fitted to the end; in the order of `mistakes`.
std::vector<Hypothesis> shortlist(const Hypothesis& as_given, const std::vector<Mistake>& mistakes,
                                  Names names) {
  std::vector<Hypothesis> guesses;
  for (const Mistake& mistake : mistakes) {
    guesses.push_back(mended(as_given, mistake));
    guesses.back().error_mm = rough_error(guesses.back(), names);
  }
  std::vector<double> errors;
  for (const Hypothesis& guess : guesses) errors.push_back(guess.error_mm);
  const std::size_t kept = std::min(kShortlist, errors.size());
  std::ranges::nth_element(errors, errors.begin() + static_cast<std::ptrdiff_t>(kept - 1));
  std::erase_if(guesses, [&](const Hypothesis& guess) { return guess.error_mm > errors[kept - 1]; });
  for (Hypothesis& guess : guesses) guess.error_mm = fitted_error(guess, names);
  return guesses;
}

std::string mm_text(double mm) {
  const int decimals = mm < 1 ? 2 : mm < 10 ? 1 : 0;
  const double unit = std::pow(10.0, decimals);
  const std::string text = std::to_string(std::round(mm * unit) / unit);
  return text.substr(0, text.find('.') + static_cast<std::size_t>(decimals > 0 ? decimals + 1 : 0)) + " mm";
}

/// The best of the guesses, the first of those as good as the least, if it explains the points better than
/// what leaves `to_beat_mm`.
std::optional<Suspicion> explanation(const std::vector<Hypothesis>& guesses, double to_beat_mm) {
  const double least = std::ranges::min_element(guesses, {}, &Hypothesis::error_mm)->error_mm;
  if (!(least < to_beat_mm)) return std::nullopt;
  Suspicion best;
  for (const Hypothesis& guess : guesses) {
    if (guess.error_mm > least * kAsGood) continue;
    if (best.sentence.empty()) {
      best.sentence = guess.what;
      best.mended_mm = guess.error_mm;
    } else {
      best.also_fits.push_back(guess.what);
    }
  }
  return best;
}

Suspicion told(Suspicion suspicion, double error_mm, const char* which) {
  suspicion.error_mm = error_mm;
  suspicion.sentence += std::string(" the ") + which + " error falls from " + mm_text(error_mm) + " to " +
                        mm_text(suspicion.mended_mm);
  return suspicion;
}

/// A mistake that shows with base and reflectors alone.
std::optional<Suspicion> gross_mistake(const Hypothesis& as_given, Names names) {
  const auto guesses = shortlist(as_given, single_mistakes(as_given.arm), names);
  auto best = explanation(guesses, as_given.error_mm / kBetter);
  // Several mistakes only where one leaves too much: they would also mimic it.
  const double left_mm = best ? best->mended_mm : as_given.error_mm;
  if (left_mm > kDeviates_mm) {
    const auto several = shortlist(as_given, combined_mistakes(as_given.arm), names);
    if (auto better = explanation(several, left_mm / kBetterOfSeveral)) best = std::move(better);
  }
  if (!best) return std::nullopt;
  return told(std::move(*best), as_given.error_mm, "coarse");
}

/// Reflectors whose names are mixed up in some poses. Judged by those poses alone: few of them would not show
/// in the error of all.
std::optional<Suspicion> mixed_reflectors(const RobotModel& nominal, const MeasurementData& data) {
  const Relabelled renamed = relabelled(nominal, data.smr_names, data.points);
  Points before, after;
  for (std::size_t k = 0; k < data.points.size(); ++k) {
    if (data.points[k].smr == renamed.points[k].smr) continue;
    before.push_back(data.points[k]);
    after.push_back(renamed.points[k]);
  }
  if (before.empty()) return std::nullopt;

  const Points sample = sampled({data.smr_names, renamed.points}, kPoses);
  const CalibratedCell cell = placed({.what = {}, .arm = nominal, .points = sample}, data.smr_names);
  const double error_mm = median(misses(cell, before));
  Suspicion mixed{.mended_mm = median(misses(cell, after))};
  if (error_mm < kDeviates_mm || error_mm < kBetterOfSeveral * mixed.mended_mm) return std::nullopt;
  mixed.sentence = "the reflectors are mixed up in " + std::to_string(renamed.rows.size()) + " of " +
                   std::to_string(pose_groups(data.points).size()) + " poses (first in row " +
                   std::to_string(renamed.rows.front()) + "): with their names exchanged";
  return told(std::move(mixed), error_mm, "coarse");
}

/// A joint whose sign hardly shows before the links are identified.
std::optional<Suspicion> hidden_sign(const RobotModel& nominal, const MeasurementData& data) {
  const Names names = data.smr_names;
  Hypothesis as_given{.what = {}, .arm = nominal, .points = sampled(data, kPosesToIdentify)};
  if (as_given.points.size() < kFewestPointsToIdentify) return std::nullopt;
  as_given.error_mm = fitted_error(as_given, names);
  std::vector<Hypothesis> guesses;
  for (const Mistake& mistake : sign_mistakes(as_given.arm)) {
    Hypothesis guess = mended(as_given, mistake);
    if (fitted_error(guess, names) > kBetter * as_given.error_mm) continue;
    guess.error_mm = identified_error(guess, names);
    guesses.push_back(std::move(guess));
  }
  if (guesses.empty()) return std::nullopt;
  const double given_mm = identified_error(as_given, names);
  auto best = explanation(guesses, std::min(given_mm / kBetterIdentified, given_mm - kShows_mm));
  if (!best) return std::nullopt;
  return told(std::move(*best), given_mm, "identified arm's");
}

}  // namespace

std::optional<Suspicion> suspect(const RobotModel& nominal, const MeasurementData& data) {
  if (pose_groups(data.points).size() < kPosesToJudge) return std::nullopt;
  Hypothesis as_given{.what = {}, .arm = nominal, .points = sampled(data, kPoses)};
  as_given.error_mm = fitted_error(as_given, data.smr_names);
  const bool off = as_given.error_mm > kDeviates_mm && !merely_deviates(as_given, data.smr_names);
  auto gross = off ? gross_mistake(as_given, data.smr_names) : std::nullopt;
  auto mixed = mixed_reflectors(nominal, data);
  if (mixed && (!gross || mixed->mended_mm < gross->mended_mm)) return mixed;
  if (gross) return gross;
  if (auto hidden = hidden_sign(nominal, data)) return hidden;
  if (as_given.error_mm <= kCannotBe_mm) return std::nullopt;
  return Suspicion{.error_mm = as_given.error_mm,
                   .mended_mm = as_given.error_mm,
                   .sentence = "the nominal arm misses the points by " + mm_text(as_given.error_mm) +
                               " and no usual mistake explains it: are these the measurements of this "
                               "robot, and is the order of its joints right?",
                   .also_fits = {}};
}

}  // namespace truepose
