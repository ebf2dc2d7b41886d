#pragma once

#include <boost/asio/any_io_executor.hpp>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "drivers/clock.hpp"
#include "drivers/net/stream.hpp"
#include "drivers/robot.hpp"
#include "drivers/wire_tap.hpp"
#include "proto/eki/messages.hpp"
#include "proto/text/random_bytes.hpp"

namespace truepose::drivers {

class EkiChannel;

struct KukaEkiOptions {
  std::string host;                   ///< the controller's address on the KLI network
  std::uint16_t motion_port = 54600;  ///< channel CellLink, served by the robot interpreter
  std::uint16_t state_port = 54601;   ///< channel CellState, served by the submit interpreter
  int joint_count = 6;                ///< 1..6; further axes are sent as 0
  WireTap motion_tap = kNullTap, state_tap = kNullTap;
  net::MakeStream stream = net::tcp_stream;  ///< of the motion channel, then of the state channel
  RandomBytes random = kernel_random;        ///< of the first command's id
};

/// A KUKA arm moved over EKI by the KRL programs in config/kuka.
///
/// A move that ended in Disconnected or Timeout keeps its id: the same move after connect() is the same
/// command for the controller, which does not carry it out twice.
class KukaEkiRobot final : public Robot {
 public:
  /// @param executor  the strand from which every call is made
  KukaEkiRobot(boost::asio::any_io_executor executor, Clock& clock, KukaEkiOptions options);
  ~KukaEkiRobot() override;

  boost::asio::awaitable<std::expected<RobotIdentity, RobotError>> connect(TimePoint deadline) override;
  /// As connect(), but changes nothing on the controller: a stop that is in effect stays.
  boost::asio::awaitable<std::expected<RobotIdentity, RobotError>> inspect(TimePoint deadline);
  boost::asio::awaitable<std::expected<RobotState, RobotError>> state(TimePoint deadline) override;
  /// By the state server alone.
  boost::asio::awaitable<std::expected<RobotState, RobotError>> look(TimePoint deadline) override;
  boost::asio::awaitable<std::expected<JointVector, RobotError>> move(MoveCommand command,
                                                                      TimePoint deadline) override;
  boost::asio::awaitable<std::expected<void, RobotError>> start_stream_program(TimePoint deadline) override;
  boost::asio::awaitable<std::expected<void, RobotError>> stop(TimePoint deadline) override;
  void disconnect() noexcept override;

  /// Whether a channel is open.
  bool linked() const;

 private:
  class Answers;

  /// @param op  what the state channel is asked for first
  boost::asio::awaitable<std::expected<RobotIdentity, RobotError>> open(eki::ControlOp op,
                                                                        TimePoint deadline);
  boost::asio::awaitable<std::expected<eki::State, RobotError>> open_state(eki::ControlOp op,
                                                                           TimePoint deadline);
  boost::asio::awaitable<std::expected<eki::Hello, RobotError>> open_motion(TimePoint deadline);
  boost::asio::awaitable<bool> drops_once_more(const RobotError& error, TimePoint last_try);
  boost::asio::awaitable<std::expected<eki::Hello, RobotError>> greeting(TimePoint deadline);
  boost::asio::awaitable<std::expected<eki::State, RobotError>> control(eki::ControlOp op,
                                                                        TimePoint deadline);
  boost::asio::awaitable<std::expected<eki::State, RobotError>> order_stop(TimePoint deadline);
  boost::asio::awaitable<std::expected<eki::Ack, RobotError>> run(eki::Command command, eki::AckState until,
                                                                  TimePoint deadline);
  RobotState robot_state(const eki::State& reported) const;
  std::int32_t next_id() { return ++last_id_; }

  Clock& clock_;
  KukaEkiOptions options_;
  std::unique_ptr<EkiChannel> motion_;
  std::unique_ptr<EkiChannel> state_;
  std::unique_ptr<Answers> answers_;
  std::int32_t last_id_;                    // of a command or a control
  std::optional<eki::Command> unfinished_;  // sent, and its end is not known
};

}  // namespace truepose::drivers
