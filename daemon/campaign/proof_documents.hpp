#pragma once

#include <boost/json/fwd.hpp>

#include "config/cell_config.hpp"
#include "daemon/campaign/campaign_result.hpp"

namespace truepose::daemon {

/// What the tracker loop came to:
/// {"tolerance_mm","rounds","readings","reached","targets":[{"target","reached",
/// "reason","joints_deg","errors_mm","averaged_mm"}]}, joints in deg (mm of a slide), empty where there are
/// none; errors rounded to 0.1 um.
boost::json::object targets_document(const TargetsResult& result, const RobotModel& robot);

/// The document of `truepose iso9283` with how it was measured: "compensated", "cube" {"x","y","z","edge"}
/// and "commanded" [{"point","x","y","z"}] in the order of a cycle, all in mm in the base frame.
boost::json::object iso9283_campaign_document(const Iso9283Test& test);

}  // namespace truepose::daemon
