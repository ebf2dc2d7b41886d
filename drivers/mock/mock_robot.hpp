#pragma once

#include "drivers/mock/mock_cell.hpp"
#include "drivers/robot.hpp"

namespace truepose::drivers {

/// An arm in the process, moved by the mock cell's own controller.
class MockRobot final : public Robot {
 public:
  explicit MockRobot(MockCell& cell) : cell_{cell} {}

  boost::asio::awaitable<std::expected<RobotIdentity, RobotError>> connect(TimePoint deadline) override;
  boost::asio::awaitable<std::expected<RobotState, RobotError>> state(TimePoint deadline) override;
  boost::asio::awaitable<std::expected<RobotState, RobotError>> look(TimePoint deadline) override;
  boost::asio::awaitable<std::expected<JointVector, RobotError>> move(MoveCommand command,
                                                                      TimePoint deadline) override;
  boost::asio::awaitable<std::expected<void, RobotError>> start_stream_program(TimePoint deadline) override;
  boost::asio::awaitable<std::expected<void, RobotError>> stop(TimePoint deadline) override;
  void disconnect() noexcept override { connected_ = false; }

  bool connected() const { return connected_; }
  /// Cannot be reached for so long.
  void leave(Duration outage) { gone_until_ = cell_.clock().now() + outage; }
  void press_emergency_stop(bool pressed) { emergency_stop_ = pressed; }

 private:
  bool may_move() const { return !emergency_stop_ && cell_.clock().now() >= drives_off_until_; }
  RobotError lose(const char* detail);

  MockCell& cell_;
  bool connected_ = false;
  bool stop_ = false;
  bool emergency_stop_ = false;
  TimePoint gone_until_{};
  TimePoint drives_off_until_{};
};

}  // namespace truepose::drivers
