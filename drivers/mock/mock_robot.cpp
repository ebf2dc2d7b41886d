#include "drivers/mock/mock_robot.hpp"

#include <algorithm>
#include <utility>

#include "core/arm/forward.hpp"

namespace truepose::drivers {

namespace asio = boost::asio;
using namespace std::chrono_literals;

namespace {

constexpr const char* kNotReady = "emergency stop";

}  // namespace

asio::awaitable<std::expected<RobotIdentity, RobotError>> MockRobot::connect(TimePoint deadline) {
  Clock& clock = cell_.clock();
  connected_ = false;
  if (clock.now() < gone_until_) {
    co_return std::unexpected(RobotError{RobotFault::Unreachable, "the controller does not answer"});
  }
  co_await clock.sleep_until(std::min(deadline, clock.now() + 200ms));
  connected_ = true;
  co_return RobotIdentity{cell_.options().robot_model, "MOCK-0001", "KSS 8.6.11"};
}

asio::awaitable<std::expected<RobotState, RobotError>> MockRobot::state(TimePoint deadline) {
  if (!connected_) co_return std::unexpected(RobotError{RobotFault::Disconnected, "not connected"});
  auto seen = co_await look(deadline);
  if (!connected_)
    co_return std::unexpected(RobotError{RobotFault::Disconnected, "the question was cut off"});
  co_return seen;
}

asio::awaitable<std::expected<RobotState, RobotError>> MockRobot::look(TimePoint deadline) {
  Clock& clock = cell_.clock();
  if (clock.now() < gone_until_)
    co_return std::unexpected(RobotError{RobotFault::Unreachable, "the controller does not answer"});
  co_await clock.sleep_until(std::min(deadline, clock.now() + 12ms));
  RobotState state;
  state.q = cell_.q();
  state.X_BF_reported = forward_kinematics(cell_.options().nominal, state.q + reported_turn_);
  state.ready = !emergency_stop_;
  state.moving = cell_.moving();
  if (!state.ready) state.why_not_ready = kNotReady;
  state.mode = "AUT";
  state.program = "active";
  state.emergency_stop = emergency_stop_;
  state.tool = cell_.tool();
  state.tool_frame = cell_.tool_frame();
  state.serial = serial_;
  co_return state;
}

asio::awaitable<std::expected<JointVector, RobotError>> MockRobot::move(MoveCommand command,
                                                                        TimePoint deadline) {
  Clock& clock = cell_.clock();
  stop_ = false;
  if (!connected_) co_return std::unexpected(RobotError{RobotFault::Disconnected, "not connected"});
  if (emergency_stop_) co_return std::unexpected(RobotError{RobotFault::NotReady, kNotReady});
  for (int i = 0; i < command.q.size(); ++i) {
    const Joint& joint = cell_.options().nominal.joints[static_cast<std::size_t>(i)];
    if (command.q[i] < joint.min || command.q[i] > joint.max) {
      co_return std::unexpected(
          RobotError{RobotFault::Refused, "axis " + std::to_string(i + 1) + " beyond its limit"});
    }
  }
  cell_.start_motion(command.q, command.speed_percent);
  TimePoint end = cell_.motion_ends() + command.settle;
  bool braked = false;
  while (clock.now() < deadline && (braked || clock.now() < end)) {
    const TimePoint next = std::min<TimePoint>(deadline, clock.now() + 250ms);
    co_await clock.sleep_until(braked ? next : std::min(end, next));
    if (const bool was = std::exchange(braked, emergency_stop_); was && !braked) {
      cell_.start_motion(command.q, command.speed_percent);
      end = cell_.motion_ends() + command.settle;
    }
    if (stop_) {
      cell_.stop_motion();
      co_return std::unexpected(RobotError{RobotFault::Aborted, "the arm was stopped on its way"});
    }
    if (!connected_)
      co_return std::unexpected(RobotError{RobotFault::Disconnected, "disconnected during a move"});
  }
  if (braked || clock.now() < end) {
    connected_ = false;
    co_return std::unexpected(
        RobotError{RobotFault::Timeout, "the controller did not report the end of the move"});
  }
  co_return cell_.q();
}

asio::awaitable<std::expected<void, RobotError>> MockRobot::start_stream_program(TimePoint deadline) {
  Clock& clock = cell_.clock();
  if (!connected_) co_return std::unexpected(RobotError{RobotFault::Disconnected, "not connected"});
  co_await clock.sleep_until(std::min(deadline, clock.now() + 100ms));
  co_return std::expected<void, RobotError>{};
}

asio::awaitable<std::expected<void, RobotError>> MockRobot::stop(TimePoint deadline) {
  Clock& clock = cell_.clock();
  if (!connected_) co_return std::unexpected(RobotError{RobotFault::Disconnected, "not connected"});
  stop_ = true;
  cell_.stop_motion();
  co_await clock.sleep_until(std::min(deadline, clock.now() + 100ms));
  co_return std::expected<void, RobotError>{};
}

void MockRobot::press_emergency_stop(bool pressed) {
  emergency_stop_ = pressed;
  if (pressed) cell_.stop_motion();
}

}  // namespace truepose::drivers
