#pragma once

#include <array>
#include <boost/asio/awaitable.hpp>
#include <chrono>
#include <expected>
#include <optional>
#include <string>

#include "core/arm/robot_model.hpp"
#include "drivers/clock.hpp"

namespace truepose::drivers {

enum class RobotFault {
  Unreachable,   ///< refused, or no route: the detail names the address
  Timeout,       ///< no answer before the deadline
  Disconnected,  ///< the connection ended; connect() may be called again
  Protocol,      ///< an answer that cannot be understood
  Refused,       ///< the controller rejected the command (out of range, not ready)
  Aborted,       ///< accepted, then stopped before it was done
  NotReady,      ///< drives off, wrong mode, emergency stop
};

inline constexpr std::array kRobotFaults{
    RobotFault::Unreachable, RobotFault::Timeout, RobotFault::Disconnected, RobotFault::Protocol,
    RobotFault::Refused,     RobotFault::Aborted, RobotFault::NotReady};

/// Whether a new connection is needed.
constexpr bool is_lost(RobotFault fault) {
  return fault == RobotFault::Unreachable || fault == RobotFault::Timeout ||
         fault == RobotFault::Disconnected || fault == RobotFault::Protocol;
}

struct RobotError {
  RobotFault fault;
  std::string detail;  ///< one sentence for the operator
};

struct RobotIdentity {
  std::string model;  ///< the controller's own name of the arm, e.g. "#KR210R2700_2 C4 FLR"
  std::string serial;
  std::string software;  ///< e.g. "KSS 8.6.11"
};

struct RobotState {
  JointVector q;  ///< actual joint positions
  Eigen::Isometry3d
      X_BF_reported;   ///< the controller's own pose of the flange in its base (RIst with tool and base 0)
  bool ready = false;  ///< may be moved: drives on, no stop pending, mode allows it
  bool moving = false;
  std::string why_not_ready;  ///< one phrase where ready is false
  double override_percent = 100;
  std::string mode;     ///< "T1", "T2", "AUT" or "EXT"
  std::string program;  ///< of the robot interpreter: "free", "reset", "active", "stopped" or "ended"
  bool emergency_stop = false;
  bool gate_open = false;
  std::optional<int> tool;  ///< number of the program's tool; none: not reported, or no tool is active
  /// The active ones: X Y Z in mm and A B C in deg, and the mass of $LOAD. None: not reported, or none is
  /// active.
  std::optional<std::array<double, 6>> tool_frame, base_frame;
  std::optional<double> load_kg;
  std::optional<std::string> serial;  ///< number of the arm; none: not reported
};

/// Why the robot is not ready and the way out: "robot: emergency stop: release it, ..".
std::string not_ready_text(const std::string& why_not_ready);

struct MoveCommand {
  JointVector q;
  double speed_percent = 20;  ///< of the joints' greatest speed
  std::chrono::milliseconds settle{500};
};

/// An arm that is moved by its own controller's point-to-point motion, one target at a time.
///
/// Every call takes a deadline, can be cancelled (then it throws operation_aborted), and leaves the object
/// usable: after Disconnected or Timeout, connect() again. Calls come from one strand, one at a time, but
/// stop(), and state() while a motion is under way.
class Robot {
 public:
  virtual ~Robot() = default;
  virtual boost::asio::awaitable<std::expected<RobotIdentity, RobotError>> connect(TimePoint deadline) = 0;
  virtual boost::asio::awaitable<std::expected<RobotState, RobotError>> state(TimePoint deadline) = 0;
  /// The same without connect(), of a controller that works for another client: nothing is released, and
  /// nothing can be moved. What it opens stays open until disconnect().
  virtual boost::asio::awaitable<std::expected<RobotState, RobotError>> look(TimePoint deadline) = 0;
  /// Moves and waits until the arm stands and has settled. A repeat after a lost connection is safe.
  /// @return the actual joint positions at the end
  virtual boost::asio::awaitable<std::expected<JointVector, RobotError>> move(MoveCommand command,
                                                                              TimePoint deadline) = 0;
  /// Starts the controller's program that opens RSI and accepts corrections.
  virtual boost::asio::awaitable<std::expected<void, RobotError>> start_stream_program(
      TimePoint deadline) = 0;
  /// Brakes the arm and leaves any program. May be called while another call is under way, and connects for
  /// it where no connection is left.
  virtual boost::asio::awaitable<std::expected<void, RobotError>> stop(TimePoint deadline) = 0;
  virtual void disconnect() noexcept = 0;
};

}  // namespace truepose::drivers
