#pragma once

#include <optional>
#include <string>

#include "config/cell_config.hpp"
#include "daemon/realtime/lock_free.hpp"
#include "daemon/realtime/stream_options.hpp"
#include "daemon/realtime/stream_status.hpp"
#include "drivers/clock.hpp"
#include "drivers/kuka/scheduling.hpp"
#include "proto/rpc/stream.hpp"

namespace truepose::daemon {

/// "the controller has sent no RSI packet for 0.6 s"
/// @param silence  none: there was no packet yet
std::string silence_text(std::optional<drivers::Duration> silence);

/// As silence_text() for a packet so old, whether it is the controller that is silent or this PC that does
/// not read what it sends.
std::string old_packet_text(const StreamStatus& status, std::optional<drivers::Duration> age);

/// Packets at the RSI port that were not accepted as the controller's, as far as they were logged.
struct RefusedPackets {
  std::optional<drivers::UdpSource> foreign;
  std::string malformed;  ///< from where, why, and how it begins
  std::string last;       ///< of either kind
};

/// Why no packet was answered since the stream was started, in words that say what to look at.
/// @param before  status when it was started
std::string no_answer_text(const StreamStatus& before, const StreamStatus& now, const RefusedPackets& refused,
                           const config::CellConfig& config);

/// State of the controller in addition to its axes.
using RobotCondition = rpc::StreamStatus::Robot;

/// "mode AUT, override 50 %, program active, emergency stop pressed, safety gate open"
std::string describe(const RobotCondition& robot);

/// What stands around the stream's own status.
struct StreamSurroundings {
  bool streaming = false;  ///< the cell is in its state "streaming" or "armed"
  bool armed = false;
  std::optional<drivers::Duration> age;  ///< of the controller's last good packet, where there was one
  std::string refused;                   ///< the last packet that was not taken, in words; empty = none
  std::string trouble;  ///< why it does not run, which the realtime thread does not know; empty = it may
  std::string frozen;   ///< what its fault says while it is frozen, which keeps a cause that was seen once
  std::string model_id;
  std::optional<int> tool{};   ///< number of the one in effect, where it is known
  bool tool_measured = false;  ///< so that its TCP is what is corrected
  RobotCondition robot{};
  std::string serial{};                         ///< of the arm that the model belongs to
  std::string why_unverified{};                 ///< why it is not known to be that one; empty: it is
  std::optional<drivers::Scheduling> thread{};  ///< the realtime one, where there is one
  StreamCounters last_minute{};                 ///< as LastMinute
};

/// How long its replies take: from datagram to reply in the kernel, and the computing of it alone.
struct StreamTimes {
  LatencyHistogram::Summary turnaround, compute;
};

rpc::StreamStatus stream_status(const StreamStatus& status, const StreamTimes& times,
                                const StreamSurroundings& around);

}  // namespace truepose::daemon
