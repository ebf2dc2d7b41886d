#include "daemon/cell/watched_devices.hpp"

#include "drivers/deadline.hpp"

namespace truepose::daemon {

using drivers::TimePoint;

namespace {

/// An abort cuts a call short. The connection is then out of step: its next answer belongs to the old call.
class Whole {
 public:
  Whole(bool& connected, std::string& why_not) : connected_{connected}, why_not_{why_not} {}
  Whole(const Whole&) = delete;
  Whole& operator=(const Whole&) = delete;
  ~Whole() {
    if (done_) return;
    connected_ = false;
    why_not_ = "a call was cut short";
  }
  void done() { done_ = true; }

 private:
  bool& connected_;
  std::string& why_not_;
  bool done_ = false;
};

}  // namespace

// The robot.

WatchedRobot::Outcome<drivers::RobotIdentity> WatchedRobot::connect(TimePoint deadline) {
  const CallQueue::Turn turn = co_await questions_.turn();
  Whole whole{connected_, why_not_};
  auto identity = co_await robot_.connect(deadline);
  whole.done();
  connected_ = identity.has_value();
  if (identity) identity_ = *identity;
  if (!identity) why_not_ = identity.error().detail;
  co_return identity;
}

WatchedRobot::Outcome<drivers::RobotState> WatchedRobot::state(TimePoint deadline) {
  const CallQueue::Turn turn = co_await questions_.turn();
  Whole whole{connected_, why_not_};
  auto state = co_await robot_.state(deadline);
  whole.done();
  note(state);
  keep(state);
  co_return state;
}

WatchedRobot::Outcome<drivers::RobotState> WatchedRobot::look(TimePoint deadline) {
  const CallQueue::Turn turn = co_await questions_.turn();
  auto state = co_await robot_.look(deadline);
  keep(state);
  if (!state) why_not_ = state.error().detail;
  co_return state;
}

WatchedRobot::Outcome<JointVector> WatchedRobot::move(drivers::MoveCommand command, TimePoint deadline) {
  auto moving = robot_.move(std::move(command), deadline);
  auto reached = co_await drivers::unless(lost_.wait(), std::move(moving));
  if (!reached) co_return std::unexpected(drivers::RobotError{drivers::RobotFault::Disconnected, why_not_});
  note(*reached);
  co_return *std::move(reached);
}

WatchedRobot::Outcome<void> WatchedRobot::start_stream_program(TimePoint deadline) {
  auto started = co_await robot_.start_stream_program(deadline);
  note(started);
  co_return started;
}

WatchedRobot::Outcome<void> WatchedRobot::stop(TimePoint deadline) {
  auto stopped = co_await robot_.stop(deadline);
  note(stopped);
  co_return stopped;
}

void WatchedRobot::disconnect() noexcept {
  robot_.disconnect();
  connected_ = false;
  last_state_.reset();
  why_not_ = "not connected";
}

template <typename T>
void WatchedRobot::note(const std::expected<T, drivers::RobotError>& outcome) {
  if (outcome || !is_lost(outcome.error().fault)) return;
  connected_ = false;
  why_not_ = outcome.error().detail;
  lost_.notify();
}

void WatchedRobot::keep(const std::expected<drivers::RobotState, drivers::RobotError>& state) {
  last_state_.reset();
  if (!state) return;
  last_state_ = *state;
  last_state_at_ = clock_.now();
}

// The tracker.

WatchedTracker::Outcome<drivers::TrackerIdentity> WatchedTracker::connect(TimePoint deadline) {
  const CallQueue::Turn turn = co_await calls_.turn();
  Whole whole{connected_, why_not_};
  auto identity = co_await tracker_.connect(deadline);
  whole.done();
  connected_ = identity.has_value();
  if (identity) identity_ = *identity;
  if (!identity) why_not_ = identity.error().detail;
  co_return identity;
}

WatchedTracker::Outcome<void> WatchedTracker::aim(Eigen::Vector3d p_W_mm, double search_radius_mm,
                                                  TimePoint deadline) {
  const CallQueue::Turn turn = co_await calls_.turn();
  Whole whole{connected_, why_not_};
  auto aimed = co_await tracker_.aim(p_W_mm, search_radius_mm, deadline);
  whole.done();
  note(aimed);
  co_return aimed;
}

WatchedTracker::Outcome<drivers::SmrPoint> WatchedTracker::measure(TimePoint deadline) {
  const CallQueue::Turn turn = co_await calls_.turn();
  Whole whole{connected_, why_not_};
  auto point = co_await tracker_.measure(deadline);
  whole.done();
  note(point);
  co_return point;
}

WatchedTracker::Outcome<void> WatchedTracker::turn_over(TimePoint deadline) {
  const CallQueue::Turn turn = co_await calls_.turn();
  Whole whole{connected_, why_not_};
  auto turned = co_await tracker_.turn_over(deadline);
  whole.done();
  note(turned);
  co_return turned;
}

WatchedTracker::Outcome<void> WatchedTracker::check(TimePoint deadline) {
  const CallQueue::Turn turn = co_await calls_.turn();
  Whole whole{connected_, why_not_};
  auto checked = co_await tracker_.check(deadline);
  whole.done();
  note(checked);
  co_return checked;
}

void WatchedTracker::disconnect() noexcept {
  tracker_.disconnect();
  connected_ = false;
  why_not_ = "not connected";
}

template <typename T>
void WatchedTracker::note(const std::expected<T, drivers::TrackerError>& outcome) {
  if (outcome || !is_lost(outcome.error().fault)) return;
  connected_ = false;
  why_not_ = outcome.error().detail;
}

}  // namespace truepose::daemon
