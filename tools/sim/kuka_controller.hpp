#pragma once

#include <chrono>
#include <cstdint>
#include <deque>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "core/arm/robot_model.hpp"
#include "core/simulate/joint_motion.hpp"
#include "proto/eki/messages.hpp"

namespace truepose::sim {

/// Time of the robot since the simulator started: real time times the speed-up.
using SimTime = std::chrono::nanoseconds;

/// Joint positions of a six-axis arm as the wire formats carry them, and back.
eki::Axes to_axes(const JointVector& q);
JointVector to_joints(const eki::Axes& axes);

struct ControllerSetup {
  RobotModel nominal;  ///< six axes
  std::string model;   ///< how the controller names its arm
  std::string serial;
  JointVector start;      ///< where the arm stands at first
  JointVector rsi_start;  ///< where the RSI program drives before it opens RSI
};

/// Why the RSI program ended.
enum class RsiEnd {
  Left,     ///< the Stop bit: RSI_MOVECORR was left cleanly
  Timeout,  ///< KSS29002: too many cycles without a valid reply
};

/// Number of the controller's message for RsiEnd::Timeout.
inline constexpr int kKss29002 = 29002;

/// The robot interpreter and the two EKI programs of a simulated KUKA controller: what they do with each
/// command, as a function of time. No I/O.
///
/// One command runs at a time, the others wait. Every call first catches up with `now`, which never goes
/// back.
class KukaController {
 public:
  explicit KukaController(ControllerSetup setup);

  eki::Hello hello() const;

  /// A document of CellLink. @return what CellLink answers at once
  std::vector<eki::Ack> command(const eki::Command& command, SimTime now);

  struct ControlAnswer {
    eki::State state;            ///< for CellState
    std::vector<eki::Ack> acks;  ///< for CellLink: a stop ends the running command
  };
  ControlAnswer control(const eki::Control& control, SimTime now);

  /// The client of CellLink is gone: what runs is braked, RSI too, and waiting commands are forgotten.
  void link_lost(SimTime now);

  /// Carries the running command on. @return what CellLink says by itself
  std::vector<eki::Ack> advance(SimTime now);

  /// When advance() next has something to do.
  std::optional<SimTime> next_change() const;

  JointVector axes(SimTime now) const;
  bool moving(SimTime now) const;
  /// How often the arm came to a stand.
  std::uint64_t stops() const { return stops_; }
  std::uint64_t moves() const { return moves_; }

  /// Speed of the RSI program's path, share of full speed, while RSI is open: its cycles drive the arm, and
  /// report it here.
  std::optional<double> rsi_speed() const;
  void rsi_cycle(const JointVector& q, bool moving);
  std::vector<eki::Ack> rsi_ended(RsiEnd end, SimTime now);

 private:
  struct Standing {};
  struct Moving {
    eki::Command command;
    JointMotion motion;
    SimTime since;
    SimTime end() const;
  };
  struct Settling {
    eki::Command command;
    SimTime until;
  };
  struct Streaming {
    eki::Command command;
    bool moving = false;
  };

  void begin(const eki::Command& command, SimTime now);
  std::optional<eki::AckError> refusal(const eki::Command& command) const;
  void brake(eki::AckError error, SimTime now);
  void stand(SimTime now);
  void say(std::int32_t id, eki::AckState state, int error = 0);
  std::vector<eki::Ack> take_said();
  double speed_scale(const eki::Command& command) const;
  eki::State report(std::int32_t id, SimTime now);

  ControllerSetup setup_;
  std::variant<Standing, Moving, Settling, Streaming> doing_;
  JointVector q_;  // where the arm stands; while it moves the motion knows
  std::deque<eki::Command> waiting_;
  std::optional<eki::Ack> last_ack_;
  std::vector<eki::Ack> said_;
  bool stopped_ = false;
  bool drives_on_ = true;
  int override_percent_ = 100;
  std::int32_t states_sent_ = 0;
  std::uint64_t stops_ = 0;
  std::uint64_t moves_ = 0;
};

}  // namespace truepose::sim
