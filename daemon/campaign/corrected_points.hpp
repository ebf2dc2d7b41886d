#pragma once

#include <vector>

#include "config/cell_config.hpp"
#include "core/data/measurement.hpp"
#include "core/quality/calibration_verdict.hpp"
#include "daemon/store/campaign_plan.hpp"
#include "daemon/store/store.hpp"

namespace truepose::daemon {

/// How the name of a nest begins that was measured: "nest 1", ...
inline constexpr const char* kNestName = "nest ";

/// The points of a campaign, as a tracker would have seen them that has no error of aim and never moved.
struct CorrectedPoints {
  std::vector<StoredPoint> points;  ///< in their order, without nests and what one face alone saw
  std::vector<Finding> findings;    ///< what nests and faces tell of the tracker
};

/// Corrections from the further measurements of a campaign. Points of one face are corrected by the constants
/// that the two faces of others show. With campaign.correct_by_nests all points are transformed into the
/// tracker's first pose, linearly between two measurements of the nests. A point that it stepped by, no one
/// knows whether before or after, is left out where that matters. Nothing is changed where nothing is
/// significant. What was measured of a reflector that no pose to identify from has shown is left out.
///
/// @param resumptions  of the campaign: what was measured since each is brought to where the tracker stood
/// when it began
CorrectedPoints corrected_points(const std::vector<StoredPoint>& measured, const config::CellConfig& config,
                                 const std::vector<Resumption>& resumptions = {});

/// The point of these that validates the pose which `again` is a compensated one of; null: none.
const StoredPoint* validation_of(const StoredPoint& again, const std::vector<StoredPoint>& points);

/// Those of them that identify and validate. One whose readings scattered, by the tracker's own account, more
/// than twice as much as those of most points counts for less.
MeasurementData campaign_data(const std::vector<StoredPoint>& measured, const config::CellConfig& config,
                              const std::vector<Resumption>& resumptions = {});

}  // namespace truepose::daemon
