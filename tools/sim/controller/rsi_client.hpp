#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/arm/robot_model.hpp"
#include "core/arm/status_turn.hpp"
#include "core/simulate/joint_motion.hpp"
#include "proto/rsi/ethernet_config.hpp"
#include "proto/rsi/frame_codec.hpp"
#include "tools/sim/controller/rsi_datagrams.hpp"
#include "tools/sim/controller/rsi_flow.hpp"

namespace truepose::sim {

/// Why an RSI session ended.
enum class RsiEnd {
  Off,          ///< the program closed it
  Timeout,      ///< KSS29002: too many cycles without a valid reply
  Monitor,      ///< AXISCORRMON: a correction larger than it allows
  PoseMonitor,  ///< POSCORRMON: the same
};

/// The controller's program while RSI is on, cycle by cycle.
class RsiProgram {
 public:
  virtual ~RsiProgram() = default;
  /// Moves the set points on by a cycle.
  /// @param actual  where the axes are
  /// @param correction  what RSI added to the set points of the last cycle
  virtual void advance(Seconds cycle, const JointVector& actual, const JointVector& correction) = 0;
  /// Time goes by, but the set points stay.
  virtual void stand(Seconds cycle) = 0;
  virtual const JointVector& set_points() const = 0;
  virtual bool moving() const = 0;
  /// Without them the axes stand where they are.
  virtual bool drives_on() const { return true; }
  /// Whether RSI applies a new correction now; else it keeps the one that it has.
  virtual bool corrects() const { return true; }
  /// Whether each correction is added to those before it (RSI_ON(#RELATIVE)).
  virtual bool is_relative() const { return false; }
  virtual FlowSources sources() const = 0;
  virtual void take(const FlowEffects& effects) = 0;
  /// Whether the program still has RSI on.
  virtual bool is_on() const = 0;
};

/// Point to point through `points`, in a loop, from the first one; leaves RSI by STOP.
class StreamPath : public RsiProgram {
 public:
  /// @param points  at least one; a single one is stood at
  StreamPath(RobotModel nominal, std::vector<JointVector> points, double speed_scale);

  void advance(Seconds cycle, const JointVector& actual, const JointVector& correction) override;
  void stand(Seconds) override {}
  const JointVector& set_points() const override { return position_; }
  bool moving() const override { return points_.size() > 1; }
  FlowSources sources() const override;
  void take(const FlowEffects& effects) override { is_left_ |= effects.leaves_movecorr; }
  bool is_on() const override { return !is_left_; }

 private:
  JointMotion leg() const;

  RobotModel nominal_;
  std::vector<JointVector> points_;
  double speed_scale_;
  std::size_t from_ = 0;
  Seconds on_leg_{0};
  JointMotion motion_;
  JointVector position_;
  bool is_left_ = false;
};

struct ServoSetup {
  Seconds dead_time{0};      ///< from a set point to the first motion
  std::vector<Seconds> lag;  ///< time constant of each axis' first-order lag; none follows at once
};

/// The drives: where the axes are for what they are given, cycle by cycle of the controller.
class Servo {
 public:
  Servo(ServoSetup setup, Seconds cycle);

  /// One cycle. @return where the axes are
  const JointVector& follow(const JointVector& given);
  void stand_at(const JointVector& q);
  const JointVector& position() const { return position_; }

 private:
  const JointVector& given_ago(std::size_t cycles) const;

  std::size_t dead_cycles_;         // whole ones
  double dead_part_;                // of one more
  JointVector share_;               // of its way that an axis goes in a cycle; empty: all of it
  std::vector<JointVector> given_;  // a ring
  std::size_t newest_ = 0;
  JointVector position_;
};

struct RsiSetup {
  RobotModel nominal;  ///< the arm that RIst and RSol are of
  rsi::EthernetConfig ethernet;
  rsi::Context context = rsi::truepose_context({});
  std::chrono::milliseconds cycle{4};
  ServoSetup servo{};
  std::optional<bool> hold_on{};    ///< in place of what the configuration says
  bool ignores_correction = false;  ///< takes replies, and moves nothing by them
  bool consecutive_delay = false;   ///< Delay counts cycles in a row without a reply, not all of the session
};

/// What the controller counts. Every cycle is answered, or its answer came late, or it was lost.
struct RsiCounters {
  std::uint64_t cycles = 0;
  std::uint64_t answered = 0;    ///< in time, and believed
  std::uint64_t late = 0;        ///< after their cycle had ended: ignored
  std::uint64_t lost = 0;        ///< no answer so far
  std::uint64_t wrong_ipoc = 0;  ///< replies to no cycle that still waits for one
  std::uint64_t rejected = 0;    ///< replies that are malformed or not of the configured SENTYPE
  std::uint64_t clamped = 0;     ///< cycles in which AXISCORR clamped an axis
  double max_step_rad =
      0;  ///< greatest change of an axis' correction (AXISCORR) in effect from one cycle to the next
  double correction_rad =
      0;  ///< greatest correction of an axis that is in effect, or was at the end of the session
};

/// The signal flow of a simulated controller and the drives behind it, one cycle at a time. No I/O and no
/// clock.
///
/// A cycle is begin_cycle(), receive() for every datagram that comes in meanwhile, end_cycle(). What is in
/// force after it moves the axes from the next cycle on, after the drives' dead time and lag, as the
/// program's set points do: AIPos and RIst are where the axes are, ASPos and RSol are the set points without
/// the correction.
class RsiClient {
 public:
  /// Throws std::invalid_argument: the context has what is not simulated, or the arm cannot be corrected so.
  RsiClient(RsiSetup setup, std::shared_ptr<RsiProgram> program, std::uint64_t first_ipoc);

  /// Moves the program on. @return the datagram to send, valid until the next call; empty where the program
  /// has switched RSI off, which ends the session
  std::string_view begin_cycle();

  enum class Reply { Valid, Late, WrongIpoc, Rejected, Unread };
  struct Verdict {
    Reply reply;
    std::uint64_t cycles_ago = 0;  ///< how long ago the answered datagram was sent
  };
  Verdict receive(std::string_view datagram);

  /// Applies the cycle's reply, or HOLDON where there was none.
  /// @return why RSI has ended, if it has
  std::optional<RsiEnd> end_cycle();

  /// The clock continues for a cycle in which nothing is sent and no reply is waited for. The set points
  /// stay.
  void pass();
  /// RSI is switched off, and on after a pause: nothing is in effect, and the arm stands where the program
  /// does.
  /// @param ipoc  first time stamp; nothing where the clock has just gone on
  void restart(std::uint64_t pause_cycles, std::optional<std::uint64_t> ipoc);
  void jump_ipoc(std::int64_t by);
  void ignore_corrections(bool ignore) { ignoring_ = ignore; }

  /// A controller of the same kind whose arm stands at the same place, and that never gives up.
  ///
  /// @param ipoc_by  how far its clock is ahead of this one's, ms; 0: far
  RsiClient twin(std::int64_t ipoc_by) const;

  /// Names in the replies that a controller ignores silently, each returned once.
  std::vector<std::string> take_unknown_names() { return replies_.take_unknown_names(); }

  /// Why replies were rejected, the first of each cause in a session.
  std::vector<std::string> take_rejections() { return std::exchange(rejections_, {}); }

  const JointVector& axes() const { return servo_.position(); }        ///< actual
  const rsi::Axes& correction_rad() const { return correction_rad_; }  ///< in effect
  std::uint64_t ipoc() const { return ipoc_; }
  bool is_on() const { return program_->is_on(); }
  bool answered() const { return reply_.has_value(); }
  const RsiCounters& counters() const { return counters_; }

 private:
  // Late answers are recognised this many cycles back.
  static constexpr std::size_t kRemembered = 1024;

  std::int64_t delay() const;
  void follow();
  JointVector given() const;
  JointVector set_points_in_force() const;
  FlowEffects total() const;
  void hold();
  void apply(const rsi::Axes& correction_rad);
  void forget_open_cycles();
  void reject(ReplyFault fault);

  RsiSetup setup_;
  RsiFlow flow_;
  int timeout_cycles_;
  ReplyReader replies_;
  RobotDatagram datagram_;
  std::shared_ptr<RsiProgram> program_;
  Servo servo_;
  ChannelValues outputs_;  ///< of the ETHERNET object
  rsi::Axes correction_rad_{};
  std::optional<StatusTurnInverse> inverse_;  ///< where POSCORR needs it
  std::optional<PoseCorrection> pose_correction_;
  std::uint64_t first_ipoc_;
  std::uint64_t ipoc_;
  bool ignoring_ = false;
  bool fresh_ = true;                     // no cycle of this session has been begun
  std::array<bool, kRemembered> open_{};  // cycles that wait for an answer
  std::optional<ReplyReader::Reply> reply_;
  int unanswered_in_a_row_ = 0;
  std::uint64_t unanswered_before_ = 0;  // this session
  RsiCounters counters_;
  std::set<ReplyFault::Cause> rejected_by_;  // this session
  std::vector<std::string> rejections_;
};

}  // namespace truepose::sim
