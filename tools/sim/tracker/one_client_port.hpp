#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <string_view>

#include "tools/sim/machine.hpp"

namespace truepose::sim {

/// Callbacks for events of a port's client.
struct PortListener {
  std::function<void()> connected;
  std::function<bool(std::string_view bytes)> received;  ///< @return whether the connection continues
  std::function<void()> lost;
};

/// A TCP port that serves one client at a time; a further one is sent a last message and closed. There are no
/// callbacks after its destruction.
class OneClientPort {
 public:
  /// Listens at once. Throws boost::system::system_error when the port cannot be bound.
  /// @param port         0 picks a free one
  /// @param turned_away  that a second client is sent
  OneClientPort(const Machine& machine, const std::string& address, std::uint16_t port,
                std::string turned_away, PortListener listener);
  ~OneClientPort();
  OneClientPort(const OneClientPort&) = delete;
  OneClientPort& operator=(const OneClientPort&) = delete;

  std::uint16_t port() const;
  /// To the client, where there is one.
  void send(std::string bytes);
  /// The same, and ends the connection once it has read that.
  void send_and_close(std::string bytes);
  /// Cuts the connection; lost() is not called.
  void drop();

 private:
  class State;
  std::shared_ptr<State> state_;
};

}  // namespace truepose::sim
