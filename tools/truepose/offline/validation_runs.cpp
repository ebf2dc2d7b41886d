#include "tools/truepose/offline/validation_runs.hpp"

#include <algorithm>
#include <boost/json.hpp>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <optional>
#include <string_view>
#include <utility>

#include "config/text_file.hpp"
#include "core/calibrate/station_split.hpp"
#include "core/data/measurement.hpp"
#include "core/math/parallel.hpp"
#include "proto/record/calibration_document.hpp"
#include "proto/record/json_io.hpp"

namespace truepose::tools {
namespace {

namespace json = boost::json;
using config::ConfigError;

/// The mean of every number over documents of the same shape (objects of numbers and such objects).
///
/// @param documents  at least one
json::value mean_document(const json::array& documents) {
  if (documents[0].is_object()) {
    json::object mean;
    for (const auto& member : documents[0].as_object()) {
      json::array values;
      for (const json::value& document : documents) values.push_back(document.at(member.key()));
      mean[member.key()] = mean_document(values);
    }
    return mean;
  }
  double sum = 0;
  bool all_equal = true;
  for (const json::value& number : documents) {
    sum += number.to_number<double>();
    all_equal = all_equal && number == documents[0];
  }
  // A count that is the same everywhere stays a whole number.
  return all_equal ? documents[0] : json::value(sum / static_cast<double>(documents.size()));
}

/// How the errors of several validations differ: {"over","count","before","geometric","after"}, each stage
/// with the standard deviations of {"mean","max","rms"}, mm.
///
/// @param validations  "validate" of each run, at least two
/// @param over         what the runs are: "splits" or "folds"
json::object spread_document(const json::array& validations, std::string_view over) {
  json::object spread{{"over", over}, {"count", static_cast<std::int64_t>(validations.size())}};
  const auto runs = static_cast<double>(validations.size());
  for (const char* stage : {"before", "geometric", "after"}) {
    json::object deviations;
    for (const char* statistic : {"mean", "max", "rms"}) {
      const auto value = [&](const json::value& run) {
        return run.at(stage).at(statistic).to_number<double>();
      };
      double mean = 0, squares = 0;
      for (const json::value& run : validations) mean += value(run) / runs;
      for (const json::value& run : validations) squares += (value(run) - mean) * (value(run) - mean);
      deviations[statistic] = std::sqrt(squares / (runs - 1));
    }
    spread[stage] = std::move(deviations);
  }
  return spread;
}

/// The runs of one validation. They may come in any order, each from a thread of its own.
class Runs {
 public:
  explicit Runs(int count) : entries_(static_cast<std::size_t>(count)) {}

  void put(int run, json::object entry, const json::object& document) {
    for (const char* key : {"converged", "iterations", "identify", "validate", "rank", "condition"}) {
      entry[key] = document.at(key);
    }
    entries_[static_cast<std::size_t>(run)] = std::move(entry);
  }

  json::array validations() const {
    json::array all;
    for (const json::object& entry : entries_) all.push_back(entry.at("validate"));
    return all;
  }

  /// @param rest_converged  what else was fitted
  void describe(json::object& document, std::string_view over, bool rest_converged = true) && {
    const auto converged = [](const json::object& entry) { return entry.at("converged").as_bool(); };
    document["converged"] = rest_converged && std::ranges::all_of(entries_, converged);
    document["spread"] = spread_document(validations(), over);
    document["splits"] = json::array(entries_.begin(), entries_.end());
  }

 private:
  std::vector<json::object> entries_;
};

/// How many threads each of the runs has for itself where all share `jobs`.
int jobs_of_each(int runs, int jobs) { return std::max(1, jobs / runs); }

/// The errors of every point under the fit that had not seen it, each from one of several threads.
class UnseenPoints {
 public:
  explicit UnseenPoints(std::size_t points) : errors_(points), documents_(points) {}

  void add(const MeasurementData& data, const Outcome& outcome) {
    for (std::size_t i = 0; i < data.points.size(); ++i) {
      if (data.points[i].set != PoseSet::Validate) continue;
      errors_[i] = outcome.calibration.points[i];
      documents_[i] = outcome.document.at("points").at(i);
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

  json::array documents() && { return std::move(documents_); }

 private:
  std::vector<PointErrors> errors_;
  json::array documents_;
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
    runs.put(i, {{"seed", own_seed}}, outcome.document);
    if (splits.repeat > 1)
      judged[static_cast<std::size_t>(i)] = {own_seed, judge(outcome),
                                             outcome.calibration.validate->after.max};
    if (i == 0) first = std::move(outcome);
  });
  if (splits.repeat > 1) {
    first->document["validate"] = mean_document(runs.validations());
    std::move(runs).describe(first->document, "splits");
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
    runs.put(fold, {{"fold", fold + 1}}, outcome.document);
    unseen.add(marked, outcome);
    distances2[static_cast<std::size_t>(fold)] = std::move(outcome.distances2);
  });
  for (Measurement& point : data.points) point.set = PoseSet::Identify;
  Outcome all = calibrate_once(data, jobs);
  all.calibration.validate = unseen.statistics(poses);
  all.distances2.clear();
  for (const auto& of_fold : distances2) std::ranges::copy(of_fold, std::back_inserter(all.distances2));
  all.document["validate"] = record::to_json(*all.calibration.validate);
  all.document["fold_points"] = std::move(unseen).documents();
  std::move(runs).describe(all.document, "folds", all.calibration.converged);
  return all;
}

}  // namespace truepose::tools
