#pragma once

#include <boost/asio/any_io_executor.hpp>
#include <chrono>
#include <cstdint>
#include <memory>

#include "tools/sim/tracker_server.hpp"

namespace truepose::sim {

/// The simulated tracker behind a bridge (proto/bridge/README.md): the reference for who writes one.
///
/// It takes as long as the emScon one for everything. Serves one client; a second one is refused as busy and
/// closed. Runs on the executor it is given (one thread or a strand); destroy it there, or when that no
/// longer runs.
class BridgeServer final : public TrackerServer {
 public:
  /// Listens at once. Throws boost::system::system_error when the port cannot be bound.
  /// @param target  outlives the server
  BridgeServer(boost::asio::any_io_executor executor, const SimulatedTarget& target, TrackerNoise noise,
               TrackerServerOptions options);
  ~BridgeServer() override;

  std::uint16_t port() const override;
  std::uint64_t measurements() const override;
  void disturb(const TrackerDisturbance& disturbance) override;
  void beam_break(std::chrono::milliseconds duration) override;
  void restart() override;

 private:
  class State;
  std::shared_ptr<State> state_;
};

}  // namespace truepose::sim
