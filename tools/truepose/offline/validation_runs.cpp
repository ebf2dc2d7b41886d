#include "tools/truepose/offline/validation_runs.hpp"

#include <boost/json.hpp>
#include <cmath>
#include <cstdint>
#include <optional>
#include <string_view>
#include <utility>

#include "config/text_file.hpp"
#include "core/identify/measurement.hpp"
#include "proto/record/calibration_document.hpp"

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

/// The runs of one validation, gathered one by one.
struct Runs {
  json::array entries, validations;
  bool converged = true;

  void add(json::object entry, const json::object& document) {
    for (const char* key : {"converged", "iterations", "identify", "validate", "rank", "condition"}) {
      entry[key] = document.at(key);
    }
    converged = converged && document.at("converged").as_bool();
    validations.push_back(document.at("validate"));
    entries.push_back(std::move(entry));
  }

  void describe(json::object& document, std::string_view over) && {
    document["converged"] = converged;
    document["spread"] = spread_document(validations, over);
    document["splits"] = std::move(entries);
  }
};

/// The errors of every point under the fit that had not seen it.
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

Outcome over_splits(const CalibrateOnce& calibrate_once, MeasurementData data, double fraction,
                    std::uint64_t seed, int repeat) {
  std::optional<Outcome> first;
  Runs runs;
  for (int i = 0; i < repeat; ++i) {
    const std::uint64_t own_seed = seed + static_cast<std::uint64_t>(i);
    split_poses(data, fraction, own_seed);
    Outcome outcome = calibrate_once(data);
    if (!outcome.calibration.validate) throw ConfigError("--split: leaves no pose to validate");
    runs.add({{"seed", own_seed}}, outcome.document);
    if (!first) first = std::move(outcome);
  }
  if (repeat > 1) {
    first->document["validate"] = mean_document(runs.validations);
    std::move(runs).describe(first->document, "splits");
  }
  return std::move(*first);
}

Outcome over_folds(const CalibrateOnce& calibrate_once, MeasurementData data, int folds, std::uint64_t seed) {
  const int poses = count_poses(data.points);
  if (folds > poses) {
    throw ConfigError("--folds: " + std::to_string(folds) + " folds of " + std::to_string(poses) +
                      " poses: at most one fold a pose");
  }
  Runs runs;
  UnseenPoints unseen(data.points.size());
  for (int fold = 0; fold < folds; ++fold) {
    hold_out_fold(data, folds, fold, seed);
    const Outcome outcome = calibrate_once(data);
    runs.add({{"fold", fold + 1}}, outcome.document);
    unseen.add(data, outcome);
  }
  for (Measurement& point : data.points) point.set = PoseSet::Identify;
  Outcome all = calibrate_once(data);
  runs.converged = runs.converged && all.calibration.converged;
  all.calibration.validate = unseen.statistics(poses);
  all.document["validate"] = record::stages_json(*all.calibration.validate);
  all.document["fold_points"] = std::move(unseen).documents();
  std::move(runs).describe(all.document, "folds");
  return all;
}

}  // namespace truepose::tools
