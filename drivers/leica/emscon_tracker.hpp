#pragma once

#include <boost/asio/any_io_executor.hpp>
#include <chrono>
#include <cstdint>
#include <expected>
#include <functional>
#include <memory>
#include <string>

#include "core/math/refraction.hpp"
#include "drivers/byte_stream.hpp"
#include "drivers/tracker.hpp"
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
  WireTap tap = kNobodyHears;
  MakeStream stream = tcp_stream;
};

/// A Leica tracker that speaks emScon (AT901, LTD, AT401/402) over TCP.
///
/// One command is outstanding at a time. What another program changes in the tracker's units or frames is put
/// right before the next point. Where it is not certain which command an answer belongs to (a command ran
/// into its deadline or was cancelled), the connection is dropped: connect() again.
class EmsconTracker final : public Tracker {
 public:
  /// @param clock  outlives the tracker
  EmsconTracker(boost::asio::any_io_executor executor, Clock& clock, EmsconOptions options);
  ~EmsconTracker() override;

  boost::asio::awaitable<std::expected<TrackerIdentity, TrackerError>> connect(TimePoint deadline) override;
  /// Connects, asks what it is and whether it could measure with the configured reflector, and disconnects:
  /// writes no setting and moves nothing.
  boost::asio::awaitable<std::expected<TrackerIdentity, TrackerError>> inspect(TimePoint deadline);
  boost::asio::awaitable<std::expected<void, TrackerError>> aim(Eigen::Vector3d p_W_mm,
                                                                double search_radius_mm,
                                                                TimePoint deadline) override;
  boost::asio::awaitable<std::expected<SmrPoint, TrackerError>> measure(TimePoint deadline) override;
  void average_over(Duration time) override;
  boost::asio::awaitable<std::expected<void, TrackerError>> turn_over(TimePoint deadline) override;
  boost::asio::awaitable<std::expected<void, TrackerError>> check(TimePoint deadline) override;
  void disconnect() noexcept override;

 private:
  class Session;
  std::unique_ptr<Session> session_;
};

}  // namespace truepose::drivers
