#pragma once

#include <boost/asio/any_io_executor.hpp>
#include <boost/asio/awaitable.hpp>
#include <chrono>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>

#include "daemon/machine.hpp"
#include "drivers/clock.hpp"
#include "drivers/condition.hpp"
#include "drivers/kuka/rsi_link.hpp"
#include "tests/world/history.hpp"
#include "tools/sim/controller/rsi_session.hpp"

namespace truepose::world {

/// A cycle of the controller, as an observer at the cable sees it.
struct RsiCycle {
  std::uint64_t session = 0;
  std::string_view datagram;         ///< that the controller sent; empty: none
  std::string_view reply;            ///< that the controller has put into effect; empty: none
  std::optional<sim::RsiEnd> end{};  ///< of the session, with this cycle
  bool ignored = false;              ///< the reply has moved nothing
  bool is_second = false;            ///< another sender's than the controller
};

/// The RSI network between the simulated controller and the cell PC.
class RsiCable {
 public:
  /// @param executor  of who waits for a session
  RsiCable(drivers::Clock& clock, History& history, const boost::asio::any_io_executor& executor)
      : clock_{clock}, history_{history}, begun_{executor} {}

  /// The PC's end: what a daemon starts in place of its RSI thread.
  /// @param executor  of the daemon's process
  daemon::StartRsiLink pc(boost::asio::any_io_executor executor);
  /// The controller's end: what a simulated cell starts in place of a thread.
  sim::StartRsi controller(boost::asio::any_io_executor executor);

  /// A datagram comes to the PC. @return its reply; empty: none
  std::string carry(std::string_view datagram, std::uint16_t from);
  drivers::Clock& clock() const { return clock_; }
  std::uint16_t next_port() { return ++last_port_; }
  std::uint64_t next_session() { return ++last_session_; }
  void session_begins() {
    ++under_way_;
    begun_.notify();
  }
  void session_ends() { --under_way_; }
  /// Returns while a session is under way, at once or when one begins.
  boost::asio::awaitable<void> session();

  bool cut = false;                                       ///< nothing passes
  drivers::Duration way{std::chrono::microseconds{150}};  ///< from a datagram to its reply
  std::function<void(const RsiCycle&)> on_cycle = [](const RsiCycle&) {};

 private:
  class Link;

  drivers::Clock& clock_;
  History& history_;
  Link* link_ = nullptr;  // of the daemon that runs
  std::uint16_t last_port_ = 50'000;
  std::uint64_t last_session_ = 0;
  int under_way_ = 0;  // sessions
  drivers::Condition begun_;
};

}  // namespace truepose::world
