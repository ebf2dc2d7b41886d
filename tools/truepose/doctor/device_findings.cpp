#include <algorithm>

#include "daemon/campaign/cell_devices.hpp"
#include "daemon/campaign/way_out.hpp"
#include "tools/truepose/doctor/diagnose.hpp"
#include "tools/truepose/text.hpp"

namespace truepose::tools {

namespace {

using Kind = FindingKind;

/// The state that a daemon tells, which is connected itself.
Findings daemon_findings(const std::string& device, const auto& status) {
  if (!status.connected) return {};
  const std::string name = shown(status.model) + ", serial " + shown(status.serial);
  if (status.why_not_ready.empty()) return {good(device, name + ", is connected")};
  return {finding<Kind::NotReady>(device, Level::Warning, name, status.why_not_ready)};
}

}  // namespace

Findings robot_findings(const config::CellConfig& cell, const Observations& seen) {
  if (!seen.robot) return daemon_findings("robot", seen.daemon.status.robot);
  const auto& robot = *seen.robot;
  if (!robot) {
    // Where another program than ours runs, EKI is not served.
    const bool streams =
        std::ranges::any_of(seen.rsi.senders, [](const RsiSender& s) { return s.frames > 0; });
    return {finding<Kind::Robot>("robot", streams ? Level::Warning : Level::Fault, robot.error().detail,
                                 daemon::way_out(robot.error().fault))};
  }
  if (const auto right = daemon::check_arm(cell.robot, robot->identity, robot->state); !right)
    return {finding<Kind::WrongArm>("robot", Level::Fault, right.error().detail, right.error().what_to_do)};
  const std::string name = robot->identity.model + ", serial " + robot->identity.serial;
  if (robot->state.ready) return {good("robot", name + ", is ready")};
  return {finding<Kind::NotReady>("robot", Level::Warning, name, robot->state.why_not_ready)};
}

Findings tracker_findings(const config::CellConfig& cell, const Observations& seen) {
  if (!seen.tracker) return daemon_findings("tracker", seen.daemon.status.tracker);
  const auto& tracker = *seen.tracker;
  if (!tracker)
    return {finding<Kind::Tracker>("tracker", Level::Fault, tracker.error().detail,
                                   daemon::way_out(tracker.error().fault, cell.tracker))};
  return {good("tracker", tracker->model + ", serial " + tracker->serial + ", can measure")};
}

}  // namespace truepose::tools
