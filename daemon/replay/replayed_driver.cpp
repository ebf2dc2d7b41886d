#include "daemon/replay/replayed_driver.hpp"

#include <utility>

#include "daemon/recorder/made_driver.hpp"
#include "daemon/recorder/recorded_robot.hpp"
#include "daemon/recorder/recorded_tracker.hpp"

namespace truepose::daemon {

namespace asio = boost::asio;
using recording::Wire;

namespace {

drivers::WireTap tap(const ReplaySurroundings& surroundings, Wire wire) {
  return [tell = surroundings.tell, wire](recording::Kind kind, std::string_view bytes) {
    tell(wire, kind, bytes);
  };
}

class ReplayedRobot final : public ReplayedDriver {
 public:
  ReplayedRobot(const MadeRobot& made, const ReplaySurroundings& surroundings)
      : robot_{surroundings.executor, surroundings.clock, options(made, surroundings)},
        recorded_{robot_, tap(surroundings, Wire::Robot), surroundings.calls} {}

  asio::awaitable<void> make(DriverCall call) override {
    switch (call.asked) {
      case Asked::Connect:
        co_await recorded_.connect(call.deadline);
        break;
      case Asked::State:
        co_await recorded_.state(call.deadline);
        break;
      case Asked::Look:
        co_await recorded_.look(call.deadline);
        break;
      case Asked::Move:
        co_await recorded_.move(call.move, call.deadline);
        break;
      case Asked::StartStreamProgram:
        co_await recorded_.start_stream_program(call.deadline);
        break;
      case Asked::Stop:
        co_await recorded_.stop(call.deadline);
        break;
      default:
        break;
    }
  }

  void make_at_once(const DriverCall& call) override {
    if (call.asked == Asked::Disconnect) recorded_.disconnect();
  }

 private:
  static drivers::KukaEkiOptions options(const MadeRobot& made, const ReplaySurroundings& surroundings) {
    drivers::KukaEkiOptions options = made.options();
    options.motion_tap = tap(surroundings, Wire::EkiLink);
    options.state_tap = tap(surroundings, Wire::EkiState);
    options.stream = [stream = surroundings.stream, state = false](const asio::any_io_executor&) mutable {
      return stream(std::exchange(state, true) ? Wire::EkiState : Wire::EkiLink);
    };
    return options;
  }

  drivers::KukaEkiRobot robot_;
  RecordedRobot recorded_;
};

class ReplayedTracker final : public ReplayedDriver {
 public:
  ReplayedTracker(const MadeTracker& made, const ReplaySurroundings& surroundings)
      : tracker_{make_tracker(
            made, {.executor = surroundings.executor,
                   .clock = surroundings.clock,
                   .air = surroundings.air,
                   .tap = tap(surroundings, Wire::Tracker),
                   .stream = [stream = surroundings.stream](
                                 const asio::any_io_executor&) { return stream(Wire::Tracker); }})},
        recorded_{*tracker_, made, tap(surroundings, Wire::Tracker), surroundings.calls} {}

  asio::awaitable<void> make(DriverCall call) override {
    switch (call.asked) {
      case Asked::Connect:
        co_await recorded_.connect(call.deadline);
        break;
      case Asked::Aim:
        co_await recorded_.aim(call.aim.p_W_mm, call.aim.search_radius_mm, call.deadline);
        break;
      case Asked::Measure:
        co_await recorded_.measure(call.deadline);
        break;
      case Asked::TurnOver:
        co_await recorded_.turn_over(call.deadline);
        break;
      case Asked::Check:
        co_await recorded_.check(call.deadline);
        break;
      default:
        break;
    }
  }

  void make_at_once(const DriverCall& call) override {
    if (call.asked == Asked::Disconnect) recorded_.disconnect();
    if (call.asked == Asked::AverageOver) recorded_.average_over(call.average);
  }

 private:
  std::unique_ptr<drivers::TimedTracker> tracker_;
  RecordedTracker recorded_;
};

}  // namespace

std::expected<std::unique_ptr<ReplayedDriver>, std::string> replayed_driver(const recording::Record& made,
                                                                            ReplaySurroundings surroundings) {
  if (made.wire == Wire::Tracker) {
    const auto tracker = read_tracker(made.bytes);
    if (!tracker) return std::unexpected(tracker.error());
    return std::make_unique<ReplayedTracker>(*tracker, surroundings);
  }
  const auto robot = read_robot(made.bytes);
  if (!robot) return std::unexpected(robot.error());
  return std::make_unique<ReplayedRobot>(*robot, surroundings);
}

}  // namespace truepose::daemon
