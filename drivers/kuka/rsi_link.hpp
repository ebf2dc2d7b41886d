#pragma once

#include <atomic>
#include <cstdint>
#include <expected>
#include <memory>
#include <string>
#include <string_view>

#include "drivers/clock.hpp"

namespace truepose::drivers {

/// What answers the controller's datagrams. One call a cycle, from the realtime thread alone: no allocation,
/// lock, log, exception or system call.
class RsiResponder {
 public:
  virtual ~RsiResponder() = default;
  /// @param received  when the datagram came in
  /// @return the reply, valid until the next call; empty = do not answer (no readable IPOC)
  virtual std::string_view answer(std::string_view datagram, TimePoint received) noexcept = 0;
};

struct RsiLinkOptions {
  std::string address;            ///< the PC's address on the RSI network
  std::uint16_t port = 0;         ///< 0 picks a free one
  int priority = 80;              ///< SCHED_FIFO, 0 = ordinary scheduling
  bool require_realtime = false;  ///< refuse to start without SCHED_FIFO and locked memory
};

/// The RSI socket on its own thread: blocking receive, answer, send to the datagram's source.
///
/// Exclusive bind, 64 KB buffer, datagrams that were cut are not answered.
class RsiLink {
 public:
  struct Counters {
    std::uint64_t received = 0, answered = 0, unanswered = 0, truncated = 0, send_failed = 0;
  };
  /// @return the running link, or one sentence that names the address and, where it can be found, who holds
  /// it.
  static std::expected<std::unique_ptr<RsiLink>, std::string> start(const RsiLinkOptions& options,
                                                                    RsiResponder& responder);
  virtual ~RsiLink() = default;  ///< ends the thread
  virtual std::uint16_t port() const = 0;
  virtual Counters counters() const = 0;
  /// How the thread really runs: "SCHED_FIFO 80, memory locked" or what was refused.
  virtual std::string scheduling() const = 0;
};

}  // namespace truepose::drivers
