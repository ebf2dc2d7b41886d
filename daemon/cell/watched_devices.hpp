#pragma once

#include <boost/asio/awaitable.hpp>
#include <optional>
#include <string>
#include <utility>

#include "daemon/threads/signal.hpp"
#include "drivers/robot.hpp"
#include "drivers/tracker.hpp"

namespace truepose::daemon {

/// Lets one call after the other to a device. For the calls of one strand.
class CallQueue {
 public:
  class Turn {
   public:
    explicit Turn(CallQueue& queue) : queue_{&queue} {}
    Turn(Turn&& other) noexcept : queue_{std::exchange(other.queue_, nullptr)} {}
    Turn& operator=(Turn&&) = delete;
    ~Turn() {
      if (queue_) queue_->end();
    }

   private:
    CallQueue* queue_;
  };

  /// Returns when no other turn lasts.
  boost::asio::awaitable<Turn> turn() {
    while (taken_) co_await ended_.wait();
    taken_ = true;
    co_return Turn{*this};
  }
  bool taken() const { return taken_; }

 private:
  void end() {
    taken_ = false;
    ended_.notify();
  }

  bool taken_ = false;
  Signal ended_;
};

/// A robot of which is known at any time whether it is connected, by what came of the last call. Calls may
/// come at any time: they are handed on one after the other, but state(), which is answered during a motion,
/// and stop(). A motion ends as soon as state() finds that the controller is gone.
class WatchedRobot final : public drivers::Robot {
 public:
  template <typename T>
  using Outcome = boost::asio::awaitable<std::expected<T, drivers::RobotError>>;

  /// @param robot, clock  outlive it
  WatchedRobot(drivers::Robot& robot, drivers::Clock& clock) : robot_{robot}, clock_{clock} {}

  Outcome<drivers::RobotIdentity> connect(drivers::TimePoint deadline) override;
  Outcome<drivers::RobotState> state(drivers::TimePoint deadline) override;
  Outcome<drivers::RobotState> look(drivers::TimePoint deadline) override;
  Outcome<JointVector> move(drivers::MoveCommand command, drivers::TimePoint deadline) override;
  Outcome<void> start_stream_program(drivers::TimePoint deadline) override;
  Outcome<void> stop(drivers::TimePoint deadline) override;
  void disconnect() noexcept override;

  /// Since connect(), while it answers.
  bool connected() const { return connected_; }
  /// Why it is not connected.
  const std::string& why_not() const { return why_not_; }
  /// Who was connected last.
  const drivers::RobotIdentity& identity() const { return identity_; }
  /// Its last state, unless it has been disconnected since or did not answer.
  const std::optional<drivers::RobotState>& last_state() const { return last_state_; }
  drivers::TimePoint last_state_at() const { return last_state_at_; }

 private:
  template <typename T>
  void note(const std::expected<T, drivers::RobotError>& outcome);
  void keep(const std::expected<drivers::RobotState, drivers::RobotError>& state);

  drivers::Robot& robot_;
  drivers::Clock& clock_;
  CallQueue questions_;
  bool connected_ = false;
  std::string why_not_ = "not connected";
  drivers::RobotIdentity identity_;
  std::optional<drivers::RobotState> last_state_;
  drivers::TimePoint last_state_at_{};
  Signal lost_;
};

/// A tracker of which is known at any time whether it is connected, by what came of the last call. Calls may
/// come at any time and are handed on one after the other.
class WatchedTracker final : public drivers::Tracker {
 public:
  template <typename T>
  using Outcome = boost::asio::awaitable<std::expected<T, drivers::TrackerError>>;

  /// @param tracker  outlives it
  explicit WatchedTracker(drivers::Tracker& tracker) : tracker_{tracker} {}

  Outcome<drivers::TrackerIdentity> connect(drivers::TimePoint deadline) override;
  Outcome<void> aim(Eigen::Vector3d p_W_mm, double search_radius_mm, drivers::TimePoint deadline) override;
  Outcome<drivers::SmrPoint> measure(drivers::TimePoint deadline) override;
  void average_over(drivers::Duration time) override { tracker_.average_over(time); }
  Outcome<void> turn_over(drivers::TimePoint deadline) override;
  Outcome<void> check(drivers::TimePoint deadline) override;
  void disconnect() noexcept override;

  /// Another program works with it.
  bool busy() const { return calls_.taken(); }
  bool connected() const { return connected_; }
  const std::string& why_not() const { return why_not_; }
  const drivers::TrackerIdentity& identity() const { return identity_; }

 private:
  template <typename T>
  void note(const std::expected<T, drivers::TrackerError>& outcome);

  drivers::Tracker& tracker_;
  CallQueue calls_;
  bool connected_ = false;
  std::string why_not_ = "not connected";
  drivers::TrackerIdentity identity_;
};

}  // namespace truepose::daemon
