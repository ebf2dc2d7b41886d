#include "tools/truepose/offline/validation_runs.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <optional>
#include <utility>

#include "config/text_file.hpp"
#include "core/calibrate/station_split.hpp"
#include "core/data/measurement.hpp"
#include "core/math/parallel.hpp"

namespace truepose::tools {
namespace {

using config::ConfigError;

/// Standard deviations over the runs, of which there are at least two.
record::StageSpread spread_of(const std::vector<record::Run>& runs, ErrorStatistics StageErrors::*stage) {
  const auto deviation = [&](double ErrorStatistics::*figure) {
    const auto value = [&](const record::Run& run) { return run.validate.*stage.*figure; };
    const auto count = static_cast<double>(runs.size());
    double mean = 0, squares = 0;
    for (const record::Run& run : runs) mean += value(run) / count;
    for (const record::Run& run : runs) squares += (value(run) - mean) * (value(run) - mean);
    return std::sqrt(squares / (count - 1));
  };
  return {deviation(&ErrorStatistics::mean), deviation(&ErrorStatistics::max),
          deviation(&ErrorStatistics::rms)};
}

/// The runs of one validation. They may come in any order, each from a thread of its own.
class Runs {
 public:
  explicit Runs(int count) : runs_(static_cast<std::size_t>(count)) {}

  /// @return the run, for what names it
  record::Run& put(int run, const record::CalibrationDocument& document) {
    return runs_[static_cast<std::size_t>(run)] = {.seed = {},
                                                   .fold = {},
                                                   .converged = document.converged,
                                                   .iterations = document.iterations,
                                                   .identify = document.identify,
                                                   .validate = document.validate.value(),
                                                   .rank = document.rank,
                                                   .condition = document.condition};
  }

  /// @param rest_converged  what else was fitted
  void describe(record::CalibrationDocument& document, record::Runs over, bool rest_converged = true) && {
    document.converged = rest_converged && std::ranges::all_of(runs_, &record::Run::converged);
    document.spread = record::Spread{.over = over,
                                     .count = static_cast<int>(runs_.size()),
                                     .before = spread_of(runs_, &StageErrors::before),
                                     .geometric = spread_of(runs_, &StageErrors::geometric),
                                     .after = spread_of(runs_, &StageErrors::after)};
    document.splits = std::move(runs_);
  }

 private:
  std::vector<record::Run> runs_;
};

/// How many threads each of the runs has for itself where all share `jobs`.
int jobs_of_each(int runs, int jobs) { return std::max(1, jobs / runs); }

/// The errors of every point under the fit that had not seen it, each from one of several threads.
class UnseenPoints {
 public:
  explicit UnseenPoints(std::size_t points) : errors_(points), points_(points) {}

  void add(const MeasurementData& data, const Outcome& outcome) {
    for (std::size_t i = 0; i < data.points.size(); ++i) {
      if (data.points[i].set != PoseSet::Validate) continue;
      errors_[i] = outcome.calibration.points[i];
      points_[i] = outcome.document.points[i];
    }
  }

  StageErrors statistics(int poses) const {
    std::vector<Eigen::Vector3d> before, geometric, after;
    for (const PointErrors& e : errors_) {
      before.push_back(e.before);
      geometric.push_back(e.geometric);
      after.push_back(e.after);
    }
    return {.poses = poses,
            .points = static_cast<int>(errors_.size()),
            .before = error_statistics(before),
            .geometric = error_statistics(geometric),
            .after = error_statistics(after)};
  }

  std::vector<record::Point> points() && { return std::move(points_); }

 private:
  std::vector<PointErrors> errors_;
  std::vector<record::Point> points_;
};

}  // namespace

Outcome over_splits(const CalibrateOnce& calibrate_once, const Judge& judge, const MeasurementData& data,
                    const Splits& splits, int jobs) {
  std::optional<Outcome> first;
  Runs runs(splits.repeat);
  std::vector<JudgedSplit> judged(static_cast<std::size_t>(splits.repeat));
  parallel_for(splits.repeat, jobs, [&](int i) {
    const std::uint64_t own_seed = splits.seed + static_cast<std::uint64_t>(i);
    MeasurementData marked = data;
    split_each_station(marked, splits.fraction, own_seed);
    Outcome outcome = calibrate_once(marked, jobs_of_each(splits.repeat, jobs));
    if (!outcome.calibration.validate) throw ConfigError("--split: leaves no pose to validate");
    runs.put(i, outcome.document).seed = own_seed;
    if (splits.repeat > 1)
      judged[static_cast<std::size_t>(i)] = {own_seed, judge(outcome),
                                             outcome.calibration.validate->after.max};
    if (i == 0) first = std::move(outcome);
  });
  if (splits.repeat > 1) {
    std::move(runs).describe(first->document, record::Runs::Splits);
    first->splits = std::move(judged);
  }
  return std::move(*first);
}

Outcome over_folds(const CalibrateOnce& calibrate_once, MeasurementData data, int folds, std::uint64_t seed,
                   int jobs) {
  const int poses = count_poses(data.points);
  if (folds > poses) {
    throw ConfigError("--folds: " + std::to_string(folds) + " folds of " + std::to_string(poses) +
                      " poses: at most one fold a pose");
  }
  Runs runs(folds);
  UnseenPoints unseen(data.points.size());
  std::vector<std::vector<double>> distances2(static_cast<std::size_t>(folds));
  parallel_for(folds, jobs, [&](int fold) {
    MeasurementData marked = data;
    hold_out_fold_of_each_station(marked, folds, fold, seed);
    if (const auto unplaced = unplaced_station(marked))
      throw ConfigError("--folds: " + *unplaced + ": use --split, which leaves it so many");
    Outcome outcome = calibrate_once(marked, jobs_of_each(folds, jobs));
    runs.put(fold, outcome.document).fold = fold + 1;
    unseen.add(marked, outcome);
    distances2[static_cast<std::size_t>(fold)] = std::move(outcome.distances2);
  });
  for (Measurement& point : data.points) point.set = PoseSet::Identify;
  Outcome all = calibrate_once(data, jobs);
  all.calibration.validate = unseen.statistics(poses);
  all.distances2.clear();
  for (const auto& of_fold : distances2) std::ranges::copy(of_fold, std::back_inserter(all.distances2));
  all.document.validate = all.calibration.validate;
  all.document.fold_points = std::move(unseen).points();
  std::move(runs).describe(all.document, record::Runs::Folds, all.calibration.converged);
  return all;
}

}  // namespace truepose::tools
