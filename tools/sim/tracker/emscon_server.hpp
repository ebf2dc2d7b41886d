#pragma once

#include <cstdint>

#include "tools/sim/machine.hpp"
#include "tools/sim/tracker/tracker_server.hpp"

namespace truepose::sim {

/// The status of the Error that a broken beam ends a measurement with. Invented: the real number is not
/// public.
inline constexpr std::int32_t kSimulatedBeamBroken = 20001;
/// The status of a FindReflector that found nothing. Invented likewise.
inline constexpr std::int32_t kSimulatedNoTarget = 20002;

/// A simulated laser tracker: an emScon TCP server that follows one target.
///
/// Initialising takes 20 s, driving 1 s, a search up to its timeout, a measurement the time that was set; all
/// of it divided by the speed-up. Once lost, a reflector is locked again only by FindReflector, within the
/// search radius of the point that was driven to. A second client gets status 10011 and is closed.
class EmsconServer final : public TrackerServer {
 public:
  /// Listens at once. Throws boost::system::system_error when the port cannot be bound.
  /// @param target  outlives the server
  EmsconServer(const Machine& machine, const SimulatedTarget& target, TrackerNoise noise,
               TrackerServerOptions options);
};

}  // namespace truepose::sim
