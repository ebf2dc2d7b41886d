#pragma once

#include <array>
#include <cstdint>
#include <expected>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "tools/sim/krl/fault.hpp"
#include "tools/sim/krl/program.hpp"

namespace truepose::sim::krl {

/// A1..A6, E1..E6: deg, or mm where the axis is linear. What the program left out stays as the motion before
/// left it.
struct AxisTarget {
  std::array<std::optional<double>, 12> axes = {};
};

/// X, Y, Z in mm and A, B, C in deg of the TCP in the base. What the program left out stays as the motion
/// before left it.
struct PoseTarget {
  std::array<std::optional<double>, 6> pose = {};
  std::optional<int> status, turn;                     ///< S, T
  std::array<std::optional<double>, 6> external = {};  ///< E1..E6
};

/// $TOOL or $BASE: X, Y, Z in mm, A, B, C in deg.
using FrameValues = std::array<double, 6>;

/// Where TRIGGER switches something.
struct SwitchingPoint {
  std::uint64_t number = 0;  ///< from 1, each once
  bool from_start = false;   ///< of the motion; else from its end
  double path_mm = 0;        ///< from there along the path; what lies beyond it is trimmed
  double delay_s = 0;        ///< below 0: so long before
};

/// A motion with all that was in effect when the program came to it.
struct Motion {
  std::uint64_t number = 0;  ///< from 1, each once
  MotionKind kind = MotionKind::Ptp;
  std::variant<AxisTarget, PoseTarget> target;
  std::optional<PoseTarget> via;           ///< of CIRC
  std::optional<double> circle_angle_deg;  ///< CA of CIRC
  std::vector<Motion> segments = {};       ///< of a spline block, which has no target itself
  std::vector<SwitchingPoint> switching = {};
  Approximation approximation = Approximation::None;
  bool is_in_tool = false;                          ///< of a relative motion: along the axes of the tool
  std::optional<double> time_percent;               ///< of a segment: TIME_BLOCK PART behind it
  std::optional<double> time_s;                     ///< of a segment: TIME_BLOCK END behind it
  std::optional<FrameValues> tool, base;            ///< none where the program never set them
  bool is_tool_fixed = false;                       ///< $IPO_MODE #TCP: the tool stands in the cell
  std::array<int, 6> velocity_percent = {};         ///< $VEL_AXIS; 100 where it was never set
  std::array<int, 6> acceleration_percent = {};     ///< $ACC_AXIS; 100 where it was never set
  std::optional<double> path_velocity_m_s;          ///< $VEL.CP
  std::optional<double> path_acceleration_m_s2;     ///< $ACC.CP
  std::optional<double> approximation_distance_mm;  ///< $APO.CDIS
  std::optional<int> approximation_percent;         ///< $APO.CPTP
};

/// A call of a subprogram that the host carries out.
struct ExternalCall {
  std::string_view name;         ///< in capitals
  std::vector<Value> arguments;  ///< the host changes those that are OUT
  bool is_first = true;          ///< false: the same call is asked again, because it was not finished
};

/// How a call went.
struct CallResult {
  bool is_finished = true;  ///< false: ask again; the program waits, and interrupts continue
  Value value = {};         ///< of a function
};

enum class Severity { Information, Error };

/// What the pendant shows.
struct Message {
  Severity severity = Severity::Information;
  std::string text;
};

/// The controller and the arm around the interpreters. All is asked for by Interpreter::run() and the program
/// control, so it happens at the time that was passed there.
class Host {
 public:
  virtual ~Host() = default;

  /// A system variable, or one element of it. @param index  from 1, within its size
  /// @return of the declared type; not set where the controller has no value now
  virtual Value read(const Variable& variable, std::optional<int> index) = 0;
  /// Errors: why it cannot be set so.
  virtual std::expected<void, std::string> write(std::string_view name, std::optional<int> index,
                                                 const Value& value) = 0;
  /// Errors: what stops the program.
  virtual std::expected<CallResult, std::string> call(ExternalCall& call) = 0;

  /// Takes a motion, to be made after those taken before. Errors: what stops the program.
  virtual std::expected<void, std::string> move(const Motion& motion) = 0;
  virtual bool is_finished(std::uint64_t motion) = 0;
  /// The switching points of motions that the arm came to since this was last asked. Delays end here even
  /// after the motion, and after cancel().
  virtual std::vector<std::uint64_t> take_switched() = 0;
  /// Whether the arm stands still.
  virtual bool is_standing() = 0;
  /// Stops the arm on its path. @param with_all_force  BRAKE F
  virtual void brake(bool with_all_force) = 0;
  /// Goes on with the motions that brake() stopped.
  virtual void go_on() = 0;
  /// Stops the arm and forgets all its motions, and a call that is not finished (RSI_MOVECORR).
  virtual void cancel() = 0;

  /// An interrupt breaks into the program now: $AXIS_INT and $POS_INT are where the arm is.
  virtual void interrupted() {}

  /// The robot program came to HALT.
  virtual void halted() {}

  virtual void show(const Message& message) = 0;
};

}  // namespace truepose::sim::krl
