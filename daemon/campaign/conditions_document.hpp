#pragma once

#include <boost/json/fwd.hpp>

#include "config/cell_config.hpp"
#include "daemon/campaign/campaign.hpp"
#include "daemon/store/store.hpp"

namespace truepose::daemon {

/// Under which conditions a campaign measured: {"started","ended","poses_measured","poses_skipped",
/// "temperature_c":{"min","max"},"pressure_mbar","humidity_percent"}, the ranges over all points; without
/// them where the tracker told no air pressure, as one without a weather station. Measurements of the
/// reference pose are not counted.
boost::json::object conditions_document(const CampaignResult& result, const CampaignRecord& record);

/// How a campaign of the cell chooses its poses and identifies, in words: {"Poses planned": "30 to identify,
/// 30 to validate", ...}.
boost::json::object options_document(const config::CellConfig& config);

/// The poses that have no point: [{"pose","attempts","reason"}], "pose" being their number in the plan.
boost::json::array skipped_document(const CampaignResult& result);

}  // namespace truepose::daemon
