#pragma once

#include <boost/asio/awaitable.hpp>
#include <cstdint>
#include <expected>
#include <utility>

#include "daemon/recorder/driver_call.hpp"
#include "daemon/recorder/made_driver.hpp"
#include "drivers/timed_tracker.hpp"
#include "drivers/wire_tap.hpp"

namespace truepose::daemon {

/// A tracker's driver of which a tap hears what it is asked for and what comes of that; and how it was made
/// and what it remembers, at first and wherever it is connected, so that a replay can begin there.
class RecordedTracker final : public drivers::Tracker {
 public:
  template <typename T>
  using Outcome = boost::asio::awaitable<std::expected<T, drivers::TrackerError>>;

  /// @param tracker  outlives it
  /// @param made     how it was
  /// @param calls    number of the call before the first
  RecordedTracker(drivers::TimedTracker& tracker, MadeTracker made, drivers::WireTap tap,
                  std::uint64_t calls = 0)
      : tracker_{tracker}, made_{std::move(made)}, tap_{std::move(tap)}, calls_{calls} {}

  Outcome<drivers::TrackerIdentity> connect(drivers::TimePoint deadline) override;
  Outcome<void> aim(Eigen::Vector3d p_W_mm, double search_radius_mm, drivers::TimePoint deadline) override;
  Outcome<drivers::SmrPoint> measure(drivers::TimePoint deadline) override;
  void average_over(drivers::Duration time) override;
  Outcome<void> turn_over(drivers::TimePoint deadline) override;
  Outcome<void> check(drivers::TimePoint deadline) override;
  void disconnect() noexcept override;

 private:
  std::uint64_t begin(DriverCall call);

  drivers::TimedTracker& tracker_;
  MadeTracker made_;
  drivers::WireTap tap_;
  std::uint64_t calls_;
  bool told_ = false;  // how it was made
};

}  // namespace truepose::daemon
