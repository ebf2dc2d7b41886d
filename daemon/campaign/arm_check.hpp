#pragma once

#include <expected>
#include <span>
#include <string>
#include <string_view>

#include "config/cell_config.hpp"
#include "core/quality/arm_identity.hpp"
#include "daemon/campaign/device_error.hpp"
#include "drivers/robot.hpp"

namespace truepose::daemon {

/// The name that the controller has for its arm, and how many joints it reports.
std::expected<void, DeviceError> check_type(const config::RobotConfig& robot,
                                            const drivers::RobotIdentity& identity,
                                            const drivers::RobotState& state);

/// The controller's own poses of the flange against the nominal arm's: a wrong arm, or a wrong robot file,
/// and of which joint, where one alone explains it.
std::expected<void, DeviceError> check_poses(const config::RobotConfig& robot,
                                             std::span<const ControllerPose> poses);

/// Both, of the pose in which the arm stands.
std::expected<void, DeviceError> check_arm(const config::RobotConfig& robot,
                                           const drivers::RobotIdentity& identity,
                                           const drivers::RobotState& state);

/// That something belongs to another arm, in one sentence; empty: it does not.
/// @param what    "the active model"
/// @param serial  of the arm that it belongs to
/// @param here    of the one that is there
std::string other_arm(std::string_view what, const std::string& serial, const std::string& here);
/// The way out where that is a model.
inline constexpr std::string_view kNeedsModelOfTheArm = "activate this arm's model, or calibrate it";

/// Whether the poses are not the nominal arm's, and each of several joints may be the cause: further poses
/// tell which.
bool is_undecided(const config::RobotConfig& robot, std::span<const ControllerPose> poses);

}  // namespace truepose::daemon
