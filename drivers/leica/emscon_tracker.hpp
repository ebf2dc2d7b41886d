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

namespace truepose::drivers {

struct EmsconOptions {
  std::string host = "192.168.0.1";
  std::uint16_t port = 700;
  std::string reflector =
      "CCR-1.5in";  ///< by the name that the tracker knows it by; empty: the first that it lists
  std::chrono::milliseconds measure{2000};
  std::chrono::milliseconds search_timeout{10000};  ///< that the tracker itself gives a search
  /// Tells the air by which distances are to be corrected, asked before each point; none: the tracker goes by
  /// its own weather station, or by what was last entered at it. An error is one sentence for the operator.
  std::function<std::expected<Air, std::string>()> air;
  /// The first connect() initialises the tracker again when it has been switched on for this long. 0: only
  /// when it asks for that.
  std::chrono::minutes initialise_again{0};
  WireTap tap = kNullTap;
  net::MakeStream stream = net::tcp_stream;
};

/// A Leica tracker that speaks emScon (AT901, LTD, AT401/402) over TCP.
///
/// One command is outstanding at a time. What another program changes in the tracker's units or frames is put
/// right before the next point. Where it is not certain which command an answer belongs to (a command ran
/// into its deadline or was cancelled), the connection is dropped: connect() again.
class EmsconTracker final : public TimedTracker {
 public:
  /// @param clock  outlives the tracker
  EmsconTracker(boost::asio::any_io_executor executor, Clock& clock, EmsconOptions options);

 private:
  class Session;
};

}  // namespace truepose::drivers
