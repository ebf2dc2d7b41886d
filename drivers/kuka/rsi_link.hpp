#pragma once

#include <cstdint>
#include <expected>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "drivers/clock.hpp"
#include "drivers/kuka/scheduling.hpp"
#include "drivers/kuka/udp_source.hpp"
#include "drivers/start_failure.hpp"

namespace truepose::drivers {

struct Datagram {
  std::string_view bytes;
  UdpSource source;
  TimePoint received;  ///< when it came to this machine, not when it was read
};

/// When what became of a datagram.
struct CycleTimes {
  TimePoint received;  ///< by the kernel
  TimePoint taken;     ///< from the kernel
  TimePoint ready;     ///< the reply, or that there is none
  TimePoint sent;      ///< to the kernel
  Duration ran{0};     ///< CPU time of the thread since the datagram before was finished
  bool replied = false;
};

/// What answers the controller's datagrams. Called by the realtime thread alone: no allocation, lock, log,
/// exception or system call.
class RsiResponder {
 public:
  virtual ~RsiResponder() = default;
  /// @return the reply to the datagram's source, valid until the next call; empty = do not answer
  virtual std::string_view answer(const Datagram& datagram) noexcept = 0;
  /// The datagram is dealt with: what need not come before its reply.
  virtual void finish(const CycleTimes& times) noexcept = 0;
  /// All that the controller had sent by `until` has been answered: what this machine kept from being read is
  /// no silence of the controller. Told while nothing comes, every 30 ms.
  virtual void on_no_datagram(TimePoint until) noexcept = 0;
};

struct RsiLinkOptions {
  std::string address;            ///< the PC's address on the RSI network
  std::uint16_t port = 0;         ///< 0 picks a free one
  int priority = 80;              ///< SCHED_FIFO, 0 = ordinary scheduling
  bool require_realtime = false;  ///< refuse to start without SCHED_FIFO and locked memory
  int cpu = -1;                   ///< where its thread runs; -1 = anywhere
  /// The controller's IPv4 address, whose datagrams never wait for those of others; none: all are read as
  /// they come.
  std::optional<std::uint32_t> controller{};
};

/// The RSI port on its own thread: blocking receive, answer, send to the datagram's source. Others than the
/// controller are heard after its datagram of the cycle, some each time, or while it is silent.
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
  /// How the thread runs now.
  virtual Scheduling scheduling() const = 0;
  /// What of the scheduling that was asked for was refused, and what to do; empty = nothing.
  virtual std::string refused() const = 0;
};

}  // namespace truepose::drivers
