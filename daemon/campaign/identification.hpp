#pragma once

#include <expected>
#include <string>
#include <vector>

#include "config/cell_config.hpp"
#include "daemon/campaign/campaign_result.hpp"

namespace truepose::daemon {

/// Fits the points of a campaign as the cell's configuration says, and judges the model: at the end of a
/// campaign, and of any stored one later. Takes long.
///
/// @param resumptions  of the campaign, by which its points are brought to one stand of the tracker
/// @return without what was measured again; else one sentence why there is no model
std::expected<CalibrationResult, std::string> identified(const std::vector<StoredPoint>& points,
                                                         const config::CellConfig& config,
                                                         const std::vector<Resumption>& resumptions = {});

/// Whether the model may be trusted, by all that was measured.
CalibrationVerdict verdict_on(const CalibrationResult& result, const std::vector<StoredPoint>& points,
                              const config::CellConfig& config,
                              const std::vector<Resumption>& resumptions = {});

/// The numbers of the poses that validate where `share` of them identify, drawn as by split_poses().
std::vector<int> drawn_to_validate(const std::vector<StoredPoint>& points, double share, std::uint64_t seed);

/// How many poses there are to identify from, or to validate on.
int count_poses(const std::vector<StoredPoint>& points, PointPurpose purpose);

}  // namespace truepose::daemon
