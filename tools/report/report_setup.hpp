#pragma once

#include <Eigen/Geometry>
#include <boost/json/fwd.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/arm/robot_model.hpp"

namespace truepose::report {

/// From the smallest to the greatest value that was met.
struct Range {
  double min = 0, max = 0;
};

/// Under which conditions a campaign measured.
struct Conditions {
  std::string started, ended;  ///< RFC 3339
  int poses_measured = 0, poses_skipped = 0;
  std::optional<Range> temperature_c, pressure_mbar, humidity_percent;
};

/// A pose that was planned and has no point.
struct Skipped {
  int pose = 0;  ///< number in the plan, from 1
  int attempts = 0;
  std::string reason;
};

/// What was measured, with what and how. A part that the document does not have is left empty.
struct Setup {
  std::optional<RobotModel> arm;          ///< nominal
  std::optional<Eigen::Isometry3d> X_WB;  ///< identified
  std::optional<Conditions> conditions;
  std::vector<Skipped> skipped;
  std::vector<double>
      reference_drift_mm;  ///< of a pose that was measured now and then, from where it was first
  std::vector<std::pair<std::string, std::string>> options, files;  ///< what each is, and its value
};

/// Throws std::invalid_argument with one sentence where a member is of the wrong kind.
Setup read_setup(const boost::json::object& document);

/// "2026-11-21 21:34 UTC" of "2026-11-21T21:34:43.239Z"; any other text as it is.
std::string time_text(const std::string& rfc3339);

}  // namespace truepose::report
