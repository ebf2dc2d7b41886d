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
  /// Its own pose of the flange is that of an arm whose joint (0 = first) is turned by so much.
  void report_joint_turned(int joint, double by_rad) { reported_turn_[joint] = by_rad; }
  /// The arm stands at once; released, a motion under way is continued.
  void press_emergency_stop(bool pressed);
  /// The state server tells the arm's number, too; none: not.
  void set_serial(std::optional<std::string> serial) { serial_ = std::move(serial); }

 private:
  MockCell& cell_;
  JointVector reported_turn_ = JointVector::Zero(cell_.options().nominal.joint_count());
  bool connected_ = false;
  bool stop_ = false;
  bool emergency_stop_ = false;
  std::optional<std::string> serial_;
  TimePoint gone_until_{};
};

}  // namespace truepose::drivers
