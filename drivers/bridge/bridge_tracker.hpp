#pragma once

#include <boost/asio/any_io_executor.hpp>
#include <chrono>
#include <cstdint>
#include <expected>
#include <functional>
#include <optional>
#include <string>

#include "core/math/refraction.hpp"
#include "drivers/net/stream.hpp"
#include "drivers/timed_tracker.hpp"
#include "drivers/wire_tap.hpp"
#include "proto/bridge/messages.hpp"

namespace truepose::drivers {

struct BridgeOptions {
  std::string host;
  std::uint16_t port = 0;
  std::string reflector;  ///< by the name that the bridge knows it by; empty: the first that it lists
  std::chrono::milliseconds measure{2000};
  std::chrono::milliseconds search_timeout{10000};  ///< that the tracker itself gives a search
  /// Tells the air by which distances are to be corrected, asked before each point; none: the tracker knows
  /// it by itself. An error is one sentence for the operator.
  std::function<std::expected<Air, std::string>()> air;
  /// The first connect() initialises the tracker again when it has been switched on for this long. 0: only
  /// when it asks for that.
  std::chrono::minutes initialise_again{0};
  WireTap tap = kNullTap;
  net::MakeStream stream = net::tcp_stream;
};

SmrPoint point_of(const bridge::Measured& result);

/// A tracker of any make behind a bridge (docs/trackers.md).
///
/// One request is outstanding at a time, but for a ping. What another program changes in the tracker is put
/// right before the next point.
class BridgeTracker final : public TimedTracker {
 public:
  /// @param clock  outlives the tracker
  BridgeTracker(boost::asio::any_io_executor executor, Clock& clock, BridgeOptions options);

 private:
  class Session;
};

}  // namespace truepose::drivers
