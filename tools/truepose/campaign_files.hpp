#pragma once

#include <boost/json/array.hpp>
#include <boost/json/object.hpp>
#include <boost/json/value.hpp>
#include <filesystem>
#include <string>

namespace truepose::tools {

/// Targets of a campaign from CSV: {"joints": rows} of q1..qN, or {"poses": rows} of x,y,z,a,b,c. Throws
/// ConfigError naming file, row and column.
boost::json::object targets_of_file(const std::filesystem::path& file);

/// The joints that were found for targets, CSV: q1..qN, and the last error in residual_mm. Targets without
/// joints are left out.
///
/// @param targets  TargetsDocument of the control protocol
std::string joints_csv(const boost::json::value& targets);

/// The cycles of an ISO 9283 test, CSV as `truepose iso9283` reads it: points in the tracker's frame, where
/// they were commanded in the robot's base. The rows of several campaigns in one file show the drift.
///
/// @param iso9283  Iso9283Document of the control protocol
/// @param started  of the campaign, which names the series
/// @param points   all points of the campaign
std::string cycles_csv(const boost::json::value& iso9283, const std::string& started,
                       const boost::json::array& points);

}  // namespace truepose::tools
