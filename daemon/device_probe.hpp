#pragma once

#include <chrono>
#include <expected>
#include <vector>

#include "daemon/check.hpp"
#include "drivers/robot.hpp"
#include "drivers/tracker.hpp"

namespace truepose::daemon {

/// How long a device is given to answer.
inline constexpr std::chrono::milliseconds kProbeTime{2500};

struct RobotObservation {
  drivers::RobotIdentity identity;
  drivers::RobotState state;
};

/// Asks the controller who and where it is; moves and releases nothing. An arm that the daemon cannot drive
/// is not asked.
std::expected<RobotObservation, drivers::RobotError> observe_robot(const config::RobotConfig& robot);

/// Asks the tracker what it is; writes and moves nothing.
std::expected<drivers::TrackerIdentity, drivers::TrackerError> observe_tracker(
    const config::TrackerConfig& tracker);

/// Both, and whether the arm is the configured one. A device that cannot be reached is a failure.
std::vector<CheckFinding> probe(const config::CellConfig& config);

}  // namespace truepose::daemon
