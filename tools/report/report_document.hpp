#pragma once

#include <Eigen/Core>
#include <boost/json/fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "core/identify/calibrate.hpp"
#include "core/math/statistics.hpp"
#include "tools/report/report_findings.hpp"
#include "tools/report/report_setup.hpp"

namespace truepose::report {

/// Error statistics of one set of points through the stages, mm.
struct Stages {
  int poses = 0;
  int points = 0;
  ErrorStatistics before, geometric, after;
};

/// One parameter with the value that the simulated arm really has, where the document knows it (mm or rad).
struct Parameter {
  IdentifiedParameter identified;
  std::optional<double> truth;
  std::optional<double> data_share;  ///< 1: known from the data alone; less: the prior says the rest
};

/// One measured point: error vectors in the tracker frame, mm.
struct Point {
  int pose = 0;
  PoseSet set = PoseSet::Identify;
  std::string smr;
  std::vector<double> joints;               ///< deg or mm; empty where not known
  std::optional<Eigen::Vector3d> position;  ///< measured, mm, tracker frame
  Eigen::Vector3d before{0, 0, 0}, geometric{0, 0, 0}, after{0, 0, 0};
  std::optional<Eigen::Vector3d> remeasured;  ///< reached with compensated joints and measured again
};

/// How the stream of corrections went.
struct Stream {
  long long cycles = 0, answered = 0, late = 0, wrong_ipoc = 0;
  long long unproven = 0, sessions = 1;
  double max_step_deg = 0;
  double p50_us = 0, p99_us = 0, p999_us = 0, max_us = 0;  ///< from a datagram's arrival to its reply
};

/// What the reports show: the calibration document with its optional extensions, read and checked.
struct ReportDocument {
  std::string robot, tracker, campaign, model, date;  ///< empty where not known
  std::string method;
  bool converged = false;
  int coarse_iterations = 0;
  int fine_iterations = 0;
  double elapsed_s = 0;
  Stages identify;
  std::optional<Stages> validate;
  std::optional<ErrorStatistics> remeasured;
  int rank = 0;  ///< of the geometric parameters
  double condition = 0;
  std::vector<Parameter> parameters;
  std::vector<Point> points;
  std::optional<Stream> stream;
  Findings findings;
  Setup setup;

  /// Those of base, reflectors and links, which the joints' deviations follow.
  std::size_t geometric_parameters() const;
  /// The set that judges the calibration: the validation points where there are any.
  const Stages& judged() const { return validate ? *validate : identify; }
  /// Whether every point was predicted by a fit to the others.
  bool cross_validated() const { return findings.spread && findings.spread->over == "folds"; }
  /// The points of that set.
  std::vector<Point> judged_points() const;
  /// The best that was shown: re-measured, else after all layers.
  const ErrorStatistics& achieved() const { return remeasured ? *remeasured : judged().after; }
  bool improved() const { return improves(judged().before, achieved()); }
};

/// Reads a calibration document, extended as render_html says.
/// Throws std::invalid_argument with one sentence where a member is missing or of the wrong kind.
ReportDocument read_document(const boost::json::object& document);

/// Whether the layers after the geometric stage changed anything.
bool has_layers(const Stages& stages);

}  // namespace truepose::report
