#include "daemon/campaign/way_out.hpp"

namespace truepose::daemon {

std::string way_out(drivers::RobotFault fault) {
  using drivers::RobotFault;
  switch (fault) {
    case RobotFault::Unreachable:
      return "start truepose_motion on the controller, and look at robot.eki_motion, robot.eki_state and the cable";
    case RobotFault::Timeout:
    case RobotFault::Disconnected:
      return "look on the pendant whether truepose_motion and the submit interpreter (sps.sub) run, and reset them";
    case RobotFault::Protocol:
      return "install the programs and EKI files that belong to this version (truepose kuka write)";
    case RobotFault::Refused:
    case RobotFault::Aborted:
    case RobotFault::NotReady:
      return "look at the messages on the pendant";
  }
  return {};
}

std::string way_out(drivers::TrackerFault fault, const config::TrackerConfig& tracker) {
  using drivers::TrackerFault;
  const bool by_bridge = tracker.protocol == config::TrackerProtocol::Bridge;
  switch (fault) {
    case TrackerFault::Unreachable:
      if (by_bridge) return "start the bridge, and look at tracker.address and the firewall of its PC";
      return "switch the tracker on, and look at tracker.address and its cable";
    case TrackerFault::Busy:
      return "close the other program that uses the tracker";
    case TrackerFault::NotReady:
      return "wait until its laser is warm, and close other programs that set it";
    case TrackerFault::Refused:
      return "look at tracker.reflector in the cell file, and at the tracker";
    case TrackerFault::Timeout:
    case TrackerFault::Disconnected:
    case TrackerFault::Protocol:
      if (by_bridge)
        return "see what the bridge does, by `truepose bridge-check " + config::text(tracker.address) + "`";
      return "see whether an emScon tracker is at tracker.address, and restart it";
    case TrackerFault::NoTarget:
    case TrackerFault::BeamBroken:
      return "put the reflector into the beam";
  }
  return {};
}

}  // namespace truepose::daemon
