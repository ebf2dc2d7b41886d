#pragma once

#include <Eigen/Geometry>
#include <string>

#include "daemon/campaign/measuring_session.hpp"

namespace truepose::daemon {

/// What has become of a cell while its campaign was interrupted.
struct SinceInterruption {
  /// Brings a point that is seen now to where the tracker would have seen it when the campaign began.
  Eigen::Isometry3d X_first_now = Eigen::Isometry3d::Identity();
  std::string found;  ///< in words
};

/// Measures the nests, and two poses that were measured before the interruption, far from each other. Where
/// these are not where they were, more of them are measured, and tell by how much tracker or base have moved.
///
/// Error: the poses cannot be seen, or no motion of the tracker explains where they are now, or too few of
/// them are there to tell.
CampaignOutcome<SinceInterruption> find_what_moved(MeasuringSession& session);

}  // namespace truepose::daemon
