#pragma once

#include <Eigen/Geometry>
#include <boost/json/fwd.hpp>
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/identify/calibrate.hpp"
#include "tools/report/json_node.hpp"

namespace truepose::report {

/// One parameter with the value that the simulated arm really has, where the document knows it (mm or rad).
struct Parameter : IdentifiedParameter {
  std::optional<double> truth;
  bool share_known = false;  ///< data_share is in the document
};

/// One measured point.
struct Point {
  int pose = 0;
  PoseSet set = PoseSet::Identify;
  std::string smr;
  std::vector<double> joints;               ///< deg or mm; empty where not known
  std::optional<Eigen::Vector3d> position;  ///< measured, mm, tracker frame
  PointErrors errors;
  std::optional<Eigen::Vector3d> remeasured;  ///< error when reached with compensated joints, measured again
};

/// How the runs of a validation differ: standard deviations, mm, of mean, max and rms alone.
struct Spread {
  bool folds = false;  ///< every pose was predicted by one of the runs; else runs with other poses each
  int runs = 0;
  ErrorStatistics before, geometric, after;
};

/// A group of joint deviations or a kind of residual field, and the error at unseen poses without and with
/// it, mm.
struct LayerChoice {
  std::string name;
  bool chosen = false;
  double without_mm = 0, with_mm = 0;
  double standard_error_mm = 0;  ///< of with_mm, 0 where not known
};

/// What was tried as one layer, the chosen first and the most useful at the top, and the error at unseen
/// poses without any of it and, of joint deviations, with all that were chosen, mm.
struct LayerSelection {
  double without_mm = 0, with_mm = 0;
  std::vector<LayerChoice> tried;
};

/// A point that the loss took out of the identification.
struct Rejected {
  std::string place;  ///< "pose 12, reflector 1, row 34", of which what is not known is left out
  double residual_mm = 0, sigmas = 0;
};

/// How well unmeasured poses are known.
struct Transfer {
  double rms_mm = 0, max_mm = 0;
  std::vector<double> worst_joints;  ///< deg or mm
  std::string warning;               ///< empty: nothing to warn of
};

/// What the reports show of a calibration document with its optional extensions, read and checked. A part
/// that the document does not have is left empty.
struct ReportDocument {
  Node json;  ///< all of it, from which a section reads what it alone shows
  std::string robot;
  bool converged = false;
  StageErrors identify;
  std::optional<StageErrors> validate;
  std::optional<ErrorStatistics> remeasured;
  std::optional<Spread> spread;
  int rank = 0;  ///< of the geometric parameters
  std::vector<Parameter> parameters;
  std::vector<Point> points;
  std::optional<LayerSelection> deviation, residual;
  std::vector<Rejected> rejected;
  std::vector<std::string> unknown, weak;  ///< sentences on what no pose shows, and on what few do
  std::optional<PriorScale> prior;         ///< where one was used
  std::optional<Transfer> transfer;
  std::optional<RobotModel> arm;          ///< nominal, as far as reports need it
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
  bool cross_validated() const { return spread && spread->folds; }
  /// The best that was shown: re-measured, else after all layers.
  const ErrorStatistics& achieved() const { return remeasured ? *remeasured : judged().after; }
  bool improved() const { return improves(judged().before, achieved()); }
};

/// Reads a calibration document, extended as render_html says, which must live as long as the result.
/// Throws std::invalid_argument with one sentence where a member is missing or of the wrong kind.
ReportDocument read_document(const boost::json::object& document);

/// Whether the layers after the geometric stage changed anything.
bool has_layers(const StageErrors& stages);

}  // namespace truepose::report
