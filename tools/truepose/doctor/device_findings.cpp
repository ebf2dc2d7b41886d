#include <algorithm>

#include "daemon/campaign/cell_devices.hpp"
#include "tools/truepose/doctor/diagnose.hpp"
#include "tools/truepose/text.hpp"

namespace truepose::tools {

namespace {

std::string next_of(drivers::RobotFault fault) {
  using drivers::RobotFault;
  switch (fault) {
    case RobotFault::Unreachable:
      return "start truepose_motion on the controller, and look at robot.eki_motion, robot.eki_state and the cable";
    case RobotFault::Timeout:
    case RobotFault::Disconnected:
      return "look on the pendant whether truepose_motion and truepose_submit run, and reset them";
    case RobotFault::Protocol:
      return "install the programs and EKI files that belong to this version: truepose kuka write";
    case RobotFault::Refused:
    case RobotFault::Aborted:
    case RobotFault::NotReady:
      break;
  }
  return "look at the messages on the pendant";
}

/// What to do about a bridge that misbehaves.
std::string try_bridge(const config::Endpoint& address) {
  return "try what it promises: truepose bridge-check " + config::text(address);
}

std::string next_of(drivers::TrackerFault fault, const config::TrackerConfig& tracker) {
  using drivers::TrackerFault;
  const bool by_bridge = tracker.protocol == config::TrackerProtocol::Bridge;
  switch (fault) {
    case TrackerFault::Unreachable:
      if (by_bridge) return "start the bridge, and look at tracker.address and the firewall of its PC";
      return "switch the tracker on, and look at tracker.address and its cable";
    case TrackerFault::Busy:
      return "close the other program that uses the tracker";
    case TrackerFault::NotReady:
      return "wait until its laser is warm";
    case TrackerFault::Refused:
      return "give one of the tracker's own names as tracker.reflector";
    case TrackerFault::Timeout:
    case TrackerFault::Disconnected:
    case TrackerFault::Protocol:
      if (by_bridge) return try_bridge(tracker.address);
      return "see whether an emScon tracker is at tracker.address, and start it anew";
    case TrackerFault::NoTarget:
    case TrackerFault::BeamBroken:
      break;
  }
  return "put the reflector into the beam";
}

/// The state that a daemon tells, which is connected itself.
Findings told(const boost::json::value& status, const std::string& device) {
  const std::string at = "/" + device;
  if (!is_true_at(status, at + "/connected")) return {};
  const std::string why_not = string_at(status, at + "/why_not_ready");
  const std::string name = text_at(status, at + "/model") + ", serial " + text_at(status, at + "/serial");
  if (why_not.empty()) return {{device, Level::Ok, name + ", is connected", ""}};
  return {{device, Level::Warning, name + ", is not ready: " + why_not, "put that right on the pendant"}};
}

}  // namespace

Findings robot_findings(const config::CellConfig& cell, const Observations& seen) {
  if (!seen.robot) return told(seen.daemon.status, "robot");
  const auto& robot = *seen.robot;
  if (!robot) {
    // Where another program than ours runs, nobody serves EKI.
    const bool streams =
        std::ranges::any_of(seen.rsi.senders, [](const RsiSender& s) { return s.frames > 0; });
    return {{"robot", streams ? Level::Warning : Level::Fault, robot.error().detail,
             next_of(robot.error().fault)}};
  }
  if (const auto right = daemon::check_arm(cell.robot, robot->identity, robot->state); !right)
    return {{"robot", Level::Fault, right.error().detail, "correct robot.file, or set tool 0 and base 0"}};
  if (!robot->state.ready)
    return {{"robot", Level::Warning, "the arm cannot be moved now: " + robot->state.why_not_ready,
             "put that right on the pendant"}};
  return {
      {"robot", Level::Ok, robot->identity.model + ", serial " + robot->identity.serial + ", is ready", ""}};
}

Findings tracker_findings(const config::CellConfig& cell, const Observations& seen) {
  if (!seen.tracker) return told(seen.daemon.status, "tracker");
  const auto& tracker = *seen.tracker;
  if (!tracker)
    return {{"tracker", Level::Fault, tracker.error().detail, next_of(tracker.error().fault, cell.tracker)}};
  return {{"tracker", Level::Ok, tracker->model + ", serial " + tracker->serial + ", can measure", ""}};
}

}  // namespace truepose::tools
