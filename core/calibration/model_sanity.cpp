#include "core/calibration/model_sanity.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/calibration/gauss_newton.hpp"
#include "core/calibration/linear_start.hpp"
#include "core/calibration/measurement_model.hpp"
#include "core/calibration/mistakes.hpp"
#include "core/calibration/parameters.hpp"
#include "core/calibration/pose_groups.hpp"
#include "core/calibration/reflector_labels.hpp"

namespace truepose {
namespace {

constexpr double kDeviates_mm = 5;     // up to here an arm may merely deviate
constexpr double kCannotBe_mm = 50;    // from here it cannot be right, whatever the reason
constexpr double kBetter = 5;          // times: a mistake explains the points when mending it gains so much
constexpr double kAsGood = 1.1;        // times: explanations that leave so much more are as good
constexpr std::size_t kPoses = 40;     // tell a mistake as well as more would
constexpr std::size_t kShortlist = 8;  // explanations fitted to the end
constexpr std::size_t kFewestPointsToTrim = 20;

using Points = std::vector<Measurement>;

/// All points of kPoses poses, spread evenly over the data.
Points sampled(const MeasurementData& data) {
  const auto groups = pose_groups(data.points);
  const std::size_t count = std::min(groups.size(), kPoses);
  Points points;
  for (std::size_t k = 0; k < count; ++k) {
    for (const std::size_t i : groups[k * groups.size() / count]) points.push_back(data.points[i]);
  }
  return points;
}

std::vector<double> misses(const CalibratedCell& cell, std::span<const Measurement> points) {
  std::vector<double> miss_mm;
  for (const Measurement& point : points) {
    miss_mm.push_back((cell.predict(point.q, point.smr) - point.p_WS_mm).norm());
  }
  return miss_mm;
}

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::ranges::nth_element(values, middle);
  return *middle;
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
struct Trial {
  std::string what;
  RobotModel arm;
  Points points;
  double error_mm = 0;
};

using Names = std::span<const std::string>;

double rough_error(const Trial& trial, Names names) {
  return median(misses(linear_start(trial.arm, names, trial.points), trial.points));
}

/// Base and reflectors fitted to the end, from the better part of the points, so that a few gross errors do
/// not speak against the arm.
double fitted_error(const Trial& trial, Names names) {
  const Points trusted = nearest(linear_start(trial.arm, names, trial.points), trial.points);
  const CalibratedCell start = linear_start(trial.arm, names, trusted);
  std::vector<int> base_and_reflectors(static_cast<std::size_t>(ParameterLayout::of(start).link(0)));
  std::iota(base_and_reflectors.begin(), base_and_reflectors.end(), 0);
  const auto fit = gauss_newton(start, trusted, base_and_reflectors, {}, {.max_iterations = 20});
  return median(misses(fit.cell, trial.points));
}

Trial mended(const Trial& as_given, const Mistake& mistake) {
  Trial trial = as_given;
  trial.what = mistake.what;
  mistake.mend(trial.arm, trial.points);
  return trial;
}

/// The most promising mistakes, fitted to the end; in the order of `mistakes`.
std::vector<Trial> shortlist(const Trial& as_given, const std::vector<Mistake>& mistakes, Names names) {
  std::vector<Trial> trials;
  for (const Mistake& mistake : mistakes) {
    trials.push_back(mended(as_given, mistake));
    trials.back().error_mm = rough_error(trials.back(), names);
  }
  std::vector<double> errors;
  for (const Trial& trial : trials) errors.push_back(trial.error_mm);
  const std::size_t kept = std::min(kShortlist, errors.size());
  std::ranges::nth_element(errors, errors.begin() + static_cast<std::ptrdiff_t>(kept - 1));
  std::erase_if(trials, [&](const Trial& trial) { return trial.error_mm > errors[kept - 1]; });
  for (Trial& trial : trials) trial.error_mm = fitted_error(trial, names);
  return trials;
}

std::optional<Trial> with_reflectors_relabelled(const Trial& as_given, const MeasurementData& data) {
  const Relabelled all = relabelled(as_given.arm, data.smr_names, data.points);
  if (all.rows.empty()) return std::nullopt;
  Trial trial = as_given;
  trial.what = "the reflectors are mixed up in " + std::to_string(all.rows.size()) + " of " +
               std::to_string(pose_groups(data.points).size()) + " poses (first in row " +
               std::to_string(all.rows.front()) + "): with their names exchanged";
  trial.points = relabelled(as_given.arm, data.smr_names, as_given.points).points;
  trial.error_mm = fitted_error(trial, data.smr_names);
  return trial;
}

std::string mm_text(double mm) {
  if (mm >= 10) return std::to_string(std::lround(mm)) + " mm";
  const long tenths = std::lround(mm * 10);
  return std::to_string(tenths / 10) + "." + std::to_string(tenths % 10) + " mm";
}

/// The best of the trials, the first of those as good as the least, if it explains the points that much
/// better than an arm that leaves `to_beat_mm`.
std::optional<Suspicion> explanation(const std::vector<Trial>& trials, double error_mm, double to_beat_mm) {
  const double least = std::ranges::min_element(trials, {}, &Trial::error_mm)->error_mm;
  if (!(least * kBetter < to_beat_mm)) return std::nullopt;
  Suspicion best{.error_mm = error_mm};
  for (const Trial& trial : trials) {
    if (trial.error_mm > least * kAsGood) continue;
    if (!best.sentence.empty()) {
      best.also_fits.push_back(trial.what);
      continue;
    }
    best.mended_mm = trial.error_mm;
    best.sentence =
        trial.what + " the coarse error falls from " + mm_text(error_mm) + " to " + mm_text(trial.error_mm);
  }
  return best;
}

}  // namespace

std::optional<Suspicion> suspect(const RobotModel& nominal, const MeasurementData& data) {
  const Names names = data.smr_names;
  Trial as_given{.what = {}, .arm = nominal, .points = sampled(data)};
  as_given.error_mm = fitted_error(as_given, names);
  if (as_given.error_mm <= kDeviates_mm) return std::nullopt;

  std::vector<Trial> trials = shortlist(as_given, single_mistakes(nominal), names);
  if (auto labels = with_reflectors_relabelled(as_given, data)) trials.push_back(std::move(*labels));
  auto best = explanation(trials, as_given.error_mm, as_given.error_mm);
  // Several mistakes only where one leaves too much: they would also mimic it.
  if (!best || best->mended_mm > kDeviates_mm) {
    const double left_mm = best ? best->mended_mm : as_given.error_mm;
    auto several =
        explanation(shortlist(as_given, combined_mistakes(nominal), names), as_given.error_mm, left_mm);
    if (several) best = std::move(several);
  }
  if (best) return best;
  if (as_given.error_mm <= kCannotBe_mm) return std::nullopt;
  return Suspicion{.error_mm = as_given.error_mm,
                   .mended_mm = as_given.error_mm,
                   .sentence = "the nominal arm misses the points by " + mm_text(as_given.error_mm) +
                               " and no usual mistake explains it: are these the measurements of this "
                               "robot, and is the order of its joints right?",
                   .also_fits = {}};
}

}  // namespace truepose
