#include "daemon/realtime/stream_status.hpp"

namespace truepose::daemon {

std::string_view name(StreamState state) {
  switch (state) {
    case StreamState::Idle:
      return "idle";
    case StreamState::RampingIn:
      return "ramping in";
    case StreamState::Active:
      return "active";
    case StreamState::RampingOut:
      return "ramping out";
    case StreamState::Frozen:
      return "frozen";
    case StreamState::Fault:
      return "fault";
  }
  return "unknown";
}

std::string_view reason(StreamFault fault) {
  switch (fault) {
    case StreamFault::None:
      return "";
    case StreamFault::NotFollowing:
      return "the axes do not follow the correction: the robot program is stopped or not at RSI_MOVECORR; "
             "start it, then "
             "acknowledge";
    case StreamFault::BoundBroken:
      return "the model asked for more than the correction bounds allow for too long; check the model and "
             "the bounds, then "
             "acknowledge";
    case StreamFault::NoSolution:
      return "the calibrated arm cannot reach the commanded poses, or only by corrections as large as a "
             "singularity asks for; check the program and the model, then acknowledge";
    case StreamFault::RepliesRejected:
      return "the controller rejects replies that were sent in time: check SENTYPE, names and IPOC in its "
             "RSI ethernet "
             "configuration, then acknowledge";
  }
  return "";
}

}  // namespace truepose::daemon
