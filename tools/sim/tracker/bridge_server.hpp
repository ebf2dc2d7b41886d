#pragma once

#include "tools/sim/machine.hpp"
#include "tools/sim/tracker/tracker_server.hpp"

namespace truepose::sim {

/// The simulated tracker behind a bridge (docs/trackers.md): the reference for a bridge of one's own.
///
/// It takes as long as the emScon one for everything. A second client is refused as busy and closed.
class BridgeServer final : public TrackerServer {
 public:
  /// Listens at once. Throws boost::system::system_error when the port cannot be bound.
  /// @param target  outlives the server
  BridgeServer(const Machine& machine, const SimulatedTarget& target, TrackerNoise noise,
               TrackerServerOptions options);
};

}  // namespace truepose::sim
