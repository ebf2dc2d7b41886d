#pragma once

#include <Eigen/Geometry>
#include <boost/json/fwd.hpp>
#include <cstddef>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "proto/record/calibration_document.hpp"

namespace truepose::report {

/// One measured point.
struct Point : record::Point {
  std::optional<Eigen::Vector3d> remeasured;  ///< error when reached with compensated joints, measured again
};

/// A group of joint deviations or the residual field, and the error at unseen poses without and with it, mm.
struct LayerChoice {
  std::string name;
  bool chosen = false;
  double without_mm = 0, with_mm = 0;
  double standard_error_mm = 0;  ///< of with_mm, 0 where not known
};

/// A calibration document with what the reports make of its parts. A prior that was not used is left out; a
/// document without a verdict gets one that is red.
struct ReportDocument : record::CalibrationDocument {
  /// Throws std::invalid_argument with one sentence where a member is missing or of the wrong kind.
  ///
  /// @param document  must live as long as this
  ReportDocument(const boost::json::object& document);

  const boost::json::object& json;            ///< as it was given
  std::vector<Point> all_points;              ///< `points`, and those of folds behind them
  std::map<std::string, double> true_values;  ///< of parameters of a simulated arm, mm or rad
  /// Groups of `non_geometric`, the chosen first and the most useful at the top.
  std::vector<LayerChoice> deviation_layers;
  std::optional<RobotModel> nominal;
  std::optional<Eigen::Isometry3d> X_WB;  ///< identified

  /// Those of base, reflectors and links, which the joints' deviations follow.
  std::size_t geometric_parameters() const;
  /// The set that judges the calibration: the validation points where there are any.
  PoseSet judging() const { return validate ? PoseSet::Validate : PoseSet::Identify; }
  std::string_view judging_name() const { return validate ? "validation" : "identification"; }
  const StageErrors& errors_of(PoseSet set) const { return set == PoseSet::Validate ? *validate : identify; }
  const StageErrors& judged() const { return errors_of(judging()); }
  std::vector<Point> points_of(PoseSet set) const;
  std::vector<Point> judged_points() const { return points_of(judging()); }
  /// Whether every point was predicted by a fit to the others.
  bool cross_validated() const { return spread && spread->over == record::Runs::Folds; }
  /// The best that was shown: re-measured, else after all layers.
  const ErrorStatistics& achieved() const { return remeasured ? *remeasured : judged().after; }
  bool improved() const { return improves(judged().before, achieved()); }
};

/// Whether the layers after the geometric stage changed anything.
bool has_layers(const StageErrors& stages);

}  // namespace truepose::report
