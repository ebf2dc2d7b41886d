#pragma once

#include <atomic>
#include <cstdint>
#include <expected>
#include <memory>
#include <string>
#include <string_view>

#include "drivers/clock.hpp"
#include "drivers/start_failure.hpp"

namespace truepose::drivers {

/// An IPv4 address and a UDP port, both in the byte order of this machine.
struct UdpSource {
  std::uint32_t address = 0;
  std::uint16_t port = 0;
  friend bool operator==(const UdpSource&, const UdpSource&) = default;
};

/// "192.168.44.1:52000"
std::string text(const UdpSource& source);

/// The IPv4 address of a host, by its number or its name; or one sentence.
std::expected<std::uint32_t, std::string> ipv4_of(const std::string& host);

struct Datagram {
  std::string_view bytes;
  UdpSource source;
  TimePoint received;  ///< when it came to this machine, not when it was read
};

/// What answers the controller's datagrams. One call a cycle, from the realtime thread alone: no allocation,
/// lock, log, exception or system call.
class RsiResponder {
 public:
  virtual ~RsiResponder() = default;
  /// @return the reply to the datagram's source, valid until the next call; empty = do not answer
  virtual std::string_view answer(const Datagram& datagram) noexcept = 0;
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
  static std::expected<std::unique_ptr<RsiLink>, StartFailure> start(const RsiLinkOptions& options,
                                                                     RsiResponder& responder);
  virtual ~RsiLink() = default;  ///< ends the thread
  virtual std::uint16_t port() const = 0;
  virtual Counters counters() const = 0;
  /// Rises with every turn of the thread, ten times a second at least: a thread that hangs does not.
  virtual std::uint64_t heartbeats() const = 0;
  /// How the thread really runs: "SCHED_FIFO 80, memory locked" or what was refused.
  virtual std::string scheduling() const = 0;
};

}  // namespace truepose::drivers
