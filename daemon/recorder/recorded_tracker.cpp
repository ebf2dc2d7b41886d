#include "daemon/recorder/recorded_tracker.hpp"

#include "daemon/recorder/recorded_outcome.hpp"

namespace truepose::daemon {

using drivers::TimePoint;

std::uint64_t RecordedTracker::begin(DriverCall call) {
  if (call.asked == Asked::Connect || !std::exchange(told_, true)) {
    made_.memory = tracker_.memory();
    tap_(recording::Kind::Driver, text(made_));
  }
  call.number = ++calls_;
  tap_(recording::Kind::Call, text(call));
  return call.number;
}

RecordedTracker::Outcome<drivers::TrackerIdentity> RecordedTracker::connect(TimePoint deadline) {
  const std::uint64_t number = begin({.asked = Asked::Connect, .deadline = deadline});
  auto call = tracker_.connect(deadline);
  auto outcome = co_await recorded_outcome(tap_, number, std::move(call));
  co_return outcome;
}

RecordedTracker::Outcome<void> RecordedTracker::aim(Eigen::Vector3d p_W_mm, double search_radius_mm,
                                                    TimePoint deadline) {
  const std::uint64_t number =
      begin({.asked = Asked::Aim, .deadline = deadline, .aim = {p_W_mm, search_radius_mm}});
  auto call = tracker_.aim(p_W_mm, search_radius_mm, deadline);
  auto outcome = co_await recorded_outcome(tap_, number, std::move(call));
  co_return outcome;
}

RecordedTracker::Outcome<drivers::SmrPoint> RecordedTracker::measure(TimePoint deadline) {
  const std::uint64_t number = begin({.asked = Asked::Measure, .deadline = deadline});
  auto call = tracker_.measure(deadline);
  auto outcome = co_await recorded_outcome(tap_, number, std::move(call));
  co_return outcome;
}

void RecordedTracker::average_over(drivers::Duration time) {
  begin({.asked = Asked::AverageOver, .average = time});
  tracker_.average_over(time);
}

RecordedTracker::Outcome<void> RecordedTracker::turn_over(TimePoint deadline) {
  const std::uint64_t number = begin({.asked = Asked::TurnOver, .deadline = deadline});
  auto call = tracker_.turn_over(deadline);
  auto outcome = co_await recorded_outcome(tap_, number, std::move(call));
  co_return outcome;
}

RecordedTracker::Outcome<void> RecordedTracker::check(TimePoint deadline) {
  const std::uint64_t number = begin({.asked = Asked::Check, .deadline = deadline});
  auto call = tracker_.check(deadline);
  auto outcome = co_await recorded_outcome(tap_, number, std::move(call));
  co_return outcome;
}

void RecordedTracker::disconnect() noexcept {
  begin({.asked = Asked::Disconnect});
  tracker_.disconnect();
}

}  // namespace truepose::daemon
