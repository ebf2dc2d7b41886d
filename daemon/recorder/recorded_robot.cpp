#include "daemon/recorder/recorded_robot.hpp"

#include "daemon/recorder/made_driver.hpp"
#include "daemon/recorder/recorded_outcome.hpp"

namespace truepose::daemon {

using drivers::TimePoint;

std::uint64_t RecordedRobot::begin(DriverCall call) {
  if (call.asked == Asked::Connect || !robot_.linked())
    tap_(recording::Kind::Driver, text(MadeRobot::of(robot_)));
  call.number = ++calls_;
  tap_(recording::Kind::Call, text(call));
  return call.number;
}

RecordedRobot::Outcome<drivers::RobotIdentity> RecordedRobot::connect(TimePoint deadline) {
  const std::uint64_t number = begin({.asked = Asked::Connect, .deadline = deadline});
  auto call = robot_.connect(deadline);
  auto outcome = co_await recorded_outcome(tap_, number, std::move(call));
  co_return outcome;
}

RecordedRobot::Outcome<drivers::RobotState> RecordedRobot::state(TimePoint deadline) {
  const std::uint64_t number = begin({.asked = Asked::State, .deadline = deadline});
  auto call = robot_.state(deadline);
  auto outcome = co_await recorded_outcome(tap_, number, std::move(call));
  co_return outcome;
}

RecordedRobot::Outcome<drivers::RobotState> RecordedRobot::look(TimePoint deadline) {
  const std::uint64_t number = begin({.asked = Asked::Look, .deadline = deadline});
  auto call = robot_.look(deadline);
  auto outcome = co_await recorded_outcome(tap_, number, std::move(call));
  co_return outcome;
}

RecordedRobot::Outcome<JointVector> RecordedRobot::move(drivers::MoveCommand command, TimePoint deadline) {
  const std::uint64_t number = begin({.asked = Asked::Move, .deadline = deadline, .move = command});
  auto call = robot_.move(std::move(command), deadline);
  auto outcome = co_await recorded_outcome(tap_, number, std::move(call));
  co_return outcome;
}

RecordedRobot::Outcome<void> RecordedRobot::start_stream_program(TimePoint deadline) {
  const std::uint64_t number = begin({.asked = Asked::StartStreamProgram, .deadline = deadline});
  auto call = robot_.start_stream_program(deadline);
  auto outcome = co_await recorded_outcome(tap_, number, std::move(call));
  co_return outcome;
}

RecordedRobot::Outcome<void> RecordedRobot::stop(TimePoint deadline) {
  const std::uint64_t number = begin({.asked = Asked::Stop, .deadline = deadline});
  auto call = robot_.stop(deadline);
  auto outcome = co_await recorded_outcome(tap_, number, std::move(call));
  co_return outcome;
}

void RecordedRobot::disconnect() noexcept {
  begin({.asked = Asked::Disconnect});
  robot_.disconnect();
}

}  // namespace truepose::daemon
