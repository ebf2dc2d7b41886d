#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <expected>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>

#include "core/arm/robot_model.hpp"
#include "core/compensate/correction_bounds.hpp"
#include "core/compensate/target_compensation.hpp"
#include "daemon/realtime/approach_watch.hpp"
#include "daemon/realtime/controller_session.hpp"
#include "daemon/realtime/correction_ramp.hpp"
#include "daemon/realtime/lateness.hpp"
#include "daemon/realtime/lock_free.hpp"
#include "daemon/realtime/model_correction.hpp"
#include "daemon/realtime/program_handshake.hpp"
#include "daemon/realtime/stream_checks.hpp"
#include "daemon/realtime/stream_options.hpp"
#include "daemon/realtime/stream_status.hpp"
#include "drivers/kuka/rsi_link.hpp"
#include "proto/recording/recording.hpp"
#include "proto/rsi/frame_codec.hpp"
#include "proto/rsi/frame_layout.hpp"

namespace truepose::daemon {

/// One RSI cycle, from the controller's datagram to the reply.
///
/// The correction is a function of the commanded axes (ASPos; where that is not sent, AIPos less the
/// correction in effect) and of the side from which they were come to: what to add so that the calibrated arm
/// stands where the nominal one would, next to the wrist singularity in position alone (TargetCompensation).
/// It is ramped in, out and between models over the controller's cycles, and passes bound_correction() just
/// before it is encoded: no reply moves an axis by more than a step from anything that the controller may
/// have in effect (ControllerSession). Every fault holds the last correction, because under absolute
/// corrections zero would be a jump; where nothing is known of what is in effect, nothing is answered, and
/// the controller holds.
///
/// The realtime thread calls answer() and finish(), one other use_model() and the commands, any status() and
/// the histograms.
class StreamCycle final : public drivers::RsiResponder {
 public:
  /// @param nominal   the arm of the robot program: six revolute joints
  /// @param ethernet  the configuration that the controller loads
  /// @param memory    what is kept from one process to the next; outlives the cycle, may be null
  /// @return the cycle, or one sentence on why this configuration cannot carry absolute axis corrections
  static std::expected<std::unique_ptr<StreamCycle>, std::string> create(const RobotModel& nominal,
                                                                         const rsi::EthernetConfig& ethernet,
                                                                         const StreamOptions& options,
                                                                         StreamMemory* memory = nullptr);

  // No allocation, lock, log, exception or system call.
  std::string_view answer(const drivers::Datagram& datagram) noexcept override;
  void finish(const drivers::CycleTimes& times) noexcept override;
  void on_no_datagram(drivers::TimePoint until) noexcept override;

  /// Corrects for `calibrated` (as many joints as the nominal arm) from the next cycle on, cross-faded from
  /// what is in effect.
  /// @param number  of the caller's choice, reported in the status; not 0
  /// @param p_F_mm  whose position comes first next to the wrist singularity, flange frame
  void use_model(const RobotModel& calibrated, std::uint64_t number,
                 const Eigen::Vector3d& p_F_mm = {0, 0, 0});
  void use_no_model() { model_.use_none(); }

  /// Ramps the correction in, or out to exactly zero. Idle follows the last cycle of the ramp.
  void engage() noexcept { engagement_.store(Engagement::On, std::memory_order_release); }
  /// The same in every session from now on, whatever silence lies between: each begins with what is proven to
  /// be in effect then, and a correction that the one before did not follow is no fault of it.
  void arm() noexcept { engagement_.store(Engagement::Armed, std::memory_order_release); }
  void disengage() noexcept { engagement_.store(Engagement::Off, std::memory_order_release); }
  /// The same, and then asks truepose_motion to leave RSI_MOVECORR, in every reply until the session has
  /// ended.
  void leave() noexcept { engagement_.store(Engagement::Leaving, std::memory_order_release); }
  /// Ends Frozen or Fault: the stream continues from the correction that it holds. @return the how many-th
  /// acknowledgement it is
  std::uint32_t acknowledge() noexcept { return acknowledged_.fetch_add(1, std::memory_order_release) + 1; }

  /// What the last answer depends on, in addition to its datagram and those before it. The realtime thread's
  /// own.
  struct Circumstances {
    bool admitted = false;  ///< the datagram was the controller's
    recording::Commands::Engagement engagement{};
    std::uint32_t acknowledged = 0;
    std::uint64_t model = 0, models = 0;    ///< its number, and how many were given
    StreamState state = StreamState::Idle;  ///< after it
    drivers::TimePoint done;                ///< when it was made; before the first: when the cycle began
  };
  Circumstances circumstances() const noexcept {
    return {admitted_, engagement_seen_, acknowledged_seen_, status_.model, models_taken_, status_.state,
            done_};
  }

  const StreamOptions& options() const noexcept { return options_; }
  StreamStatus status() const;
  /// From the kernel's receipt of a datagram to its reply in the kernel's hands.
  LatencyHistogram::Summary turnaround() const noexcept { return turnaround_.summary(); }
  /// Of this, from the datagram in hand to the reply that is ready.
  LatencyHistogram::Summary compute() const noexcept { return compute_.summary(); }
  /// The same in full.
  const LatencyHistogram& turnaround_times() const noexcept { return turnaround_; }
  const LatencyHistogram& compute_times() const noexcept { return compute_; }

  /// Next event for the log, in order. One thread. @return false where there is none
  bool next_event(StreamEvent& event) noexcept { return events_.pop(event); }
  std::uint64_t dropped_events() const noexcept { return events_.dropped(); }

 private:
  /// The arm under the correction that was in effect.
  struct Moved {
    rsi::RobotFrame frame;
    JointVector correction;
    std::uint64_t elapsed = 0;
  };
  using Engagement = recording::Commands::Engagement;
  using Turn = ControllerSession::Turn;
  using FrameVerdict = ControllerSession::FrameVerdict;

  StreamCycle(const RobotModel& nominal, const rsi::EthernetConfig& ethernet, const StreamOptions& options,
              StreamMemory* memory);

  void take_commands() noexcept;
  bool take_acknowledgement() noexcept;  ///< @return whether there was one
  void acknowledge_fault() noexcept;
  void count(const drivers::CycleTimes& times) noexcept;
  void report_foreign(const drivers::UdpSource& source) noexcept;
  std::string_view answer_controller(const drivers::Datagram& datagram) noexcept;
  void report_unread(const rsi::FrameError& error, const drivers::Datagram& datagram) noexcept;
  std::string_view answer_frame(const rsi::RobotFrame& frame, const drivers::Datagram& datagram) noexcept;
  std::string_view answer_malformed(const rsi::FrameError& error, const drivers::Datagram& datagram) noexcept;
  std::string_view answer_cycle(const rsi::RobotFrame& frame, const FrameVerdict& verdict,
                                drivers::TimePoint received) noexcept;
  std::string_view hold() noexcept;
  std::string_view repeat(std::uint64_t ipoc) noexcept;
  std::string_view reply() noexcept;
  StreamForProgram seen_by_program() const noexcept;

  bool wanted() const noexcept { return engagement() >= Engagement::On; }
  bool engaged() const noexcept { return wanted() && !status_.program_declines; }
  bool at_rest() const noexcept { return ramp_.out() && correction_.isZero(0); }
  bool asks_to_leave() const noexcept;
  Engagement engagement() const noexcept { return engagement_seen_; }
  void listen_to_program(const rsi::ProgramSignals& program) noexcept;
  void begin_session(const drivers::UdpSource& source) noexcept;
  void adopt(const JointVector& commanded) noexcept;
  void disarm_after_silence(drivers::TimePoint received) noexcept;

  std::optional<JointVector> commanded_axes(const rsi::RobotFrame& frame) const noexcept;
  bool plausible(const JointVector& commanded, const FrameVerdict& verdict) noexcept;
  void watch(const rsi::RobotFrame& frame, const FrameVerdict& verdict, drivers::TimePoint received) noexcept;
  void watch_effect() noexcept;
  void look_at_arm(const rsi::RobotFrame& frame, std::uint64_t elapsed) noexcept;
  bool correct(const JointVector& commanded, double cycles) noexcept;
  void count(const CorrectionClamps& clamps) noexcept;
  FoundFault unsolved() const noexcept;
  FoundFault joint_limit(Eigen::Index axis, double q_rad) const noexcept;
  FoundFault broken_bound(const JointVector& commanded, const JointVector& wanted,
                          const BoundedCorrection& bounded) const noexcept;

  void raise(const std::optional<FoundFault>& found) noexcept;
  void update_state() noexcept;
  void emit(StreamEvent event) noexcept;
  void publish() noexcept;

  // Fixed from the start.
  const RobotModel nominal_;
  const StreamOptions options_;
  const CorrectionBounds bounds_;
  const rsi::SensorFrameCodec codec_;
  const bool has_stop_;
  const bool sends_aspos_;

  // Between the threads.
  ModelCorrection model_;
  std::atomic<Engagement> engagement_{Engagement::Off};
  std::atomic<std::uint32_t> acknowledged_{0};
  mutable std::mutex status_mutex_;  // among the readers of the status
  mutable SnapshotExchange<StreamStatus> published_;
  SpscRing<StreamEvent, 1024> events_;
  LatencyHistogram turnaround_, compute_;

  // The realtime thread's own.
  rsi::RobotFrameDecoder decoder_;
  drivers::TimePoint done_;                       // with the last datagram of the controller
  Engagement engagement_seen_ = Engagement::Off;  // one for the whole of a cycle
  std::uint64_t models_taken_ = 0;
  bool admitted_ = false;  // the datagram that is dealt with is the controller's
  ControllerSession session_;
  MissingElements missing_;
  LateReplies late_replies_;
  Lateness lateness_;
  FollowingCheck following_;
  std::optional<Moved> moved_;  // still to be looked at
  ArmCheck arm_check_;
  ApproachWatch approach_;
  ProgramHandshake program_;
  CorrectionRamp ramp_;
  StreamStatus status_;
  std::array<char, rsi::kMaxFrameBytes> buffer_{};
  std::optional<std::uint64_t> replied_ipoc_;  // of the reply in buffer_
  std::size_t reply_bytes_ = 0;
  std::uint32_t acknowledged_seen_ = 0;
  JointVector correction_;  // sent last
  bool arm_known_;          // of an armed stream's session, also by the process before
  bool behind_ = false;     // a bound keeps the correction from what the ramp wants
  bool malformed_before_ = false;
  bool unread_reported_ = false;
  Engagement engagement_before_ = Engagement::Off;  // at the last frame
  double broken_ = 0;                               // cycles in a row, as the next
  double unsolved_ = 0;
  int implausible_ = 0;                         // frames in a row
  std::optional<drivers::TimePoint> received_;  // the datagram before
  std::optional<JointVector> last_commanded_;
  std::array<std::uint32_t, 8> foreign_{};  // addresses that were named
  std::size_t foreign_count_ = 0;
};

}  // namespace truepose::daemon
