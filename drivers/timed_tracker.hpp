#pragma once

#include <chrono>
#include <cstdint>
#include <memory>

#include "drivers/initialise_again.hpp"
#include "drivers/tracker.hpp"
#include "drivers/tracker_wire.hpp"

namespace truepose::drivers {

/// What a driver does with its tracker, without deadlines: the calls of Tracker, and inspect() of
/// TimedTracker. Where a call is cancelled it leaves the dialogue in a state from which the next one
/// continues, or the connection closed.
class TrackerDialogue {
 public:
  virtual ~TrackerDialogue() = default;
  virtual TrackerTask<TrackerIdentity> connect() = 0;
  virtual TrackerTask<TrackerIdentity> inspect() = 0;
  virtual TrackerTask<void> aim(Eigen::Vector3d p_W_mm, double search_radius_mm) = 0;
  virtual TrackerTask<SmrPoint> measure() = 0;
  virtual TrackerTask<void> turn_over() = 0;
  virtual TrackerTask<void> check() = 0;
  virtual void average_over(Duration time) = 0;
  virtual void close() noexcept = 0;
};

/// A tracker by the dialogue with it, each call until its deadline.
class TimedTracker : public Tracker {
 public:
  /// @param clock  outlives the tracker
  TimedTracker(Clock& clock, std::unique_ptr<TrackerDialogue> dialogue)
      : clock_{clock}, dialogue_{std::move(dialogue)} {}

  boost::asio::awaitable<std::expected<TrackerIdentity, TrackerError>> connect(TimePoint deadline) override;
  /// Connects, asks what it is and whether it could measure with the configured reflector, and disconnects:
  /// writes no setting and moves nothing.
  boost::asio::awaitable<std::expected<TrackerIdentity, TrackerError>> inspect(TimePoint deadline);
  boost::asio::awaitable<std::expected<void, TrackerError>> aim(Eigen::Vector3d p_W_mm,
                                                                double search_radius_mm,
                                                                TimePoint deadline) override;
  boost::asio::awaitable<std::expected<SmrPoint, TrackerError>> measure(TimePoint deadline) override;
  void average_over(Duration time) override { dialogue_->average_over(time); }
  boost::asio::awaitable<std::expected<void, TrackerError>> turn_over(TimePoint deadline) override;
  boost::asio::awaitable<std::expected<void, TrackerError>> check(TimePoint deadline) override;
  void disconnect() noexcept override { dialogue_->close(); }

 private:
  Clock& clock_;
  std::unique_ptr<TrackerDialogue> dialogue_;
};

/// It did not do `what` in time: "was not initialised".
TrackerError late(std::string_view what);

}  // namespace truepose::drivers
