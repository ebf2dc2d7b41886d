#include <algorithm>

#include "daemon/campaign/cell_devices.hpp"
#include "daemon/campaign/way_out.hpp"
#include "tools/truepose/doctor/diagnose.hpp"
#include "tools/truepose/text.hpp"

namespace truepose::tools {

namespace {

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
             daemon::way_out(robot.error().fault)}};
  }
  if (const auto right = daemon::check_arm(cell.robot, robot->identity, robot->state); !right)
    return {{"robot", Level::Fault, right.error().detail, right.error().what_to_do}};
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
    return {{"tracker", Level::Fault, tracker.error().detail,
             daemon::way_out(tracker.error().fault, cell.tracker)}};
  return {{"tracker", Level::Ok, tracker->model + ", serial " + tracker->serial + ", can measure", ""}};
}

}  // namespace truepose::tools
