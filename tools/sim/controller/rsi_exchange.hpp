#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "config/scenario_fault.hpp"
#include "tools/sim/controller/rsi_client.hpp"

namespace truepose::sim {

/// The network that an exchange sends to.
class RsiWire {
 public:
  virtual ~RsiWire() = default;
  virtual void send(std::string_view datagram) = 0;
  /// RSI was switched off and is on again: from another port, where the controller has no fixed one.
  virtual void restarted() = 0;
  /// @param from  numeric address that the second controller sends from; empty: any
  virtual void begin_second_sender(RsiClient twin, const std::string& from) = 0;
};

/// The controller's side of one RSI session, with the faults of a scenario: what it sends, and when. No I/O
/// and no clock.
///
/// A cycle is begin_faults() until it returns false, begin_cycle(), send(), receive() for every datagram that
/// comes in until tick(), and end_cycle() at tick().
class RsiExchange {
 public:
  using Time = std::chrono::steady_clock::time_point;

  /// @param faults  those of RSI, in cycles
  /// @param cycles_before  those of earlier sessions: faults count on
  RsiExchange(RsiWire& wire, RsiClient client, std::chrono::nanoseconds cycle,
              std::vector<config::ScenarioFault> faults, std::uint64_t cycles_before);

  /// The coming cycle begins at this time and has its whole length.
  void begin_at(Time tick) { tick_ = tick; }
  /// When the cycle under way ends, and the next begins.
  Time tick() const { return tick_; }

  /// A fault that begins with the coming cycle, whatever its `at` says; in cycles.
  void disturb(config::ScenarioFault fault);

  /// Begins the faults of the coming cycle, up to the next one that makes the controller pause.
  /// @return whether it pauses: take its silent cycles, then receive(), then call this again
  bool begin_faults();
  bool begin_silent_cycle();  ///< false where the pause is over
  void end_silent_cycle();

  /// @return false where the program has switched RSI off, which ends the session
  bool begin_cycle();
  /// Sends the cycle's datagram, if the faults let it.
  void send(Time now);
  /// @return time from the datagram to this reply; nothing where the reply answers none
  std::optional<std::chrono::nanoseconds> receive(std::string_view reply, Time received);
  void end_cycle() { end_ = client_.end_cycle(); }
  /// Why the session has ended, if it has.
  std::optional<RsiEnd> end() const { return end_; }

  /// Whether a fault of this kind covers the cycle under way.
  bool covers(config::ScenarioFault::Kind kind) const;
  /// Number of the cycle that begins next, counted over all sessions.
  std::uint64_t coming_cycle() const { return cycles_before_ + client_.counters().cycles + 1; }
  const RsiClient& client() const { return client_; }

  std::vector<std::string> take_unknown_names() { return client_.take_unknown_names(); }
  std::vector<std::string> take_rejections() { return client_.take_rejections(); }

 private:
  bool begin(const config::ScenarioFault& fault);
  std::string garbled() const;

  RsiWire& wire_;
  RsiClient client_;
  std::chrono::nanoseconds cycle_;
  std::vector<config::ScenarioFault> faults_;
  std::uint64_t cycles_before_;
  Time tick_;
  std::optional<RsiEnd> end_;
  std::int64_t cycle_number_ = 0;
  std::size_t next_fault_ = 0;  // of those that begin with the coming cycle
  std::int64_t silent_cycles_ = 0;
  bool restarting_ = false;
  std::string_view datagram_;  // of the cycle under way
  std::string held_back_, late_;
  std::array<Time, 1024> sent_{};
  std::uint64_t sent_count_ = 0;
};

}  // namespace truepose::sim
