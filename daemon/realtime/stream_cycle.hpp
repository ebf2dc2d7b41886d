#pragma once

#include <array>
#include <atomic>
#include <chrono>
#include <cstdint>
#include <expected>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>

#include "config/cell_config.hpp"
#include "core/compensation/correction_bounds.hpp"
#include "core/compensation/target_compensation.hpp"
#include "core/kinematics/angles.hpp"
#include "core/kinematics/robot_model.hpp"
#include "daemon/realtime/ipoc_sequence.hpp"
#include "daemon/realtime/latency_histogram.hpp"
#include "daemon/realtime/snapshot_exchange.hpp"
#include "daemon/realtime/spsc_ring.hpp"
#include "daemon/realtime/stream_status.hpp"
#include "drivers/kuka/rsi_link.hpp"
#include "proto/rsi/frame_codec.hpp"

namespace truepose::daemon {

/// How the stream behaves. A cycle is a step of the controller's IPOC, never of this machine's clock.
struct StreamOptions {
  double max_step_rad = 0;
  double max_total_rad = 0;
  double limit_margin_rad = 0;
  double singular_below_rad = 0;  ///< CompensationOptions::singular_below
  int ramp_cycles = 250;          ///< from no correction to all of it, and from one model to the next
  int broken_cycles = 250;        ///< a bound broken for so many in a row is a fault
  int following_cycles = 250;     ///< axes that do not follow for so many in a row freeze the command
  double following_tolerance_rad = 0.05 * kRadPerDeg;
  int following_lag_cycles = 40;  ///< by which a moving arm may trail its command
  int rejected_cycles = 8;        ///< so many late replies in a row that were sent in time are a fault
  int timeout_cycles =
      100;  ///< the controller gives up after so many cycles without a reply: what comes then is a new start
  drivers::TimePoint (*now)() noexcept = &std::chrono::steady_clock::now;  ///< for the turnaround only

  static StreamOptions of(const config::StreamConfig& config);
};

/// One RSI cycle, from the controller's datagram to the reply.
///
/// The correction is a function of the commanded axes (ASPos; where that is not sent, AIPos less the
/// correction in force): what to add so that the calibrated arm stands where the nominal one would, next to
/// the wrist singularity in position alone (TargetCompensation). It is ramped in, out and between models over
/// the controller's cycles, and passes bound_correction() just before it is encoded. Every fault holds the
/// last correction, because under absolute corrections zero would be a jump; only a new start of the
/// controller's side begins at zero, because there the controller does.
///
/// answer() belongs to the realtime thread, use_model() and the commands to one other, status() and
/// turnaround() to any.
class StreamCycle final : public drivers::RsiResponder {
 public:
  /// @param nominal   the arm of the robot program: six revolute joints
  /// @param ethernet  the configuration that the controller loads
  /// @return the cycle, or one sentence on why this configuration cannot carry absolute axis corrections
  static std::expected<std::unique_ptr<StreamCycle>, std::string> create(const RobotModel& nominal,
                                                                         const rsi::EthernetConfig& ethernet,
                                                                         const StreamOptions& options);

  // No allocation, lock, log, exception or system call.
  std::string_view answer(std::string_view datagram, drivers::TimePoint received) noexcept override;

  /// Corrects for `calibrated` (as many joints as the nominal arm) from the next cycle on, cross-faded from
  /// what is in force.
  /// @param number  of the caller's choice, reported in the status; not 0
  /// @param p_F_mm  whose position comes first next to the wrist singularity, flange frame
  void use_model(const RobotModel& calibrated, std::uint64_t number,
                 const Eigen::Vector3d& p_F_mm = {0, 0, 0});
  void use_no_model();

  /// Ramps the correction in, or out to exactly zero. Idle follows the last cycle of the ramp.
  void engage() noexcept { engaged_.store(true, std::memory_order_release); }
  void disengage() noexcept { engaged_.store(false, std::memory_order_release); }
  /// Ends Frozen or Fault: the stream goes on from the correction that it holds.
  void acknowledge() noexcept { acknowledged_.fetch_add(1, std::memory_order_release); }

  StreamStatus status() const;
  LatencyHistogram::Summary turnaround() const noexcept { return turnaround_.summary(); }

  /// Next event for the log, in order. One thread. @return false where there is none
  bool next_event(StreamEvent& event) noexcept { return events_.pop(event); }
  std::uint64_t dropped_events() const noexcept { return events_.dropped(); }

 private:
  struct Model {
    std::uint64_t number = 0;  // 0 = none
    std::optional<TargetCompensation> compensation;
    Eigen::Vector3d p_F_mm{0, 0, 0};
  };
  using Place = IpocSequence::Place;
  using Position = IpocSequence::Position;

  StreamCycle(const RobotModel& nominal, const rsi::EthernetConfig& ethernet, const StreamOptions& options);

  void take_commands() noexcept;
  std::string_view answer_frame(const rsi::RobotFrame& frame, drivers::TimePoint received) noexcept;
  std::string_view answer_malformed(std::optional<std::uint64_t> ipoc) noexcept;
  std::string_view hold(std::uint64_t ipoc, const Position& position) noexcept;
  std::string_view reply(std::uint64_t ipoc, const JointVector& correction) noexcept;

  bool restarted(const rsi::RobotFrame& frame, const Position& position) const noexcept;
  void start_session(std::uint64_t ipoc) noexcept;
  void advance(std::uint64_t ipoc, const Position& position) noexcept;

  std::optional<JointVector> commanded_axes(const rsi::RobotFrame& frame) const noexcept;
  bool plausible(const JointVector& commanded, const Position& position) noexcept;
  bool replies_arrive(const rsi::RobotFrame& frame, const Position& position,
                      drivers::TimePoint received) noexcept;
  void watch_following(const rsi::RobotFrame& frame, const JointVector& commanded,
                       const Position& position) noexcept;
  bool solve(const JointVector& commanded) noexcept;
  bool correct(const JointVector& commanded, double cycles) noexcept;
  void count(const CorrectionClamps& clamps) noexcept;

  void raise(StreamFault fault) noexcept;
  void update_state() noexcept;
  void emit(StreamEventKind kind, std::uint64_t value = 0) noexcept;
  void publish() noexcept;

  // Fixed from the start.
  const RobotModel nominal_;
  const StreamOptions options_;
  const CorrectionBounds bounds_;
  const rsi::SensorFrameCodec codec_;
  const bool has_stop_;
  const bool sends_aspos_;

  // Between the threads.
  SnapshotExchange<Model> model_;
  std::atomic<bool> engaged_{false};
  std::atomic<std::uint32_t> acknowledged_{0};
  mutable std::mutex status_mutex_;  // among the readers of the status
  mutable SnapshotExchange<StreamStatus> published_;
  SpscRing<StreamEvent, 1024> events_;
  LatencyHistogram turnaround_;

  // The realtime thread's own.
  IpocSequence sequence_;
  StreamStatus status_;
  std::array<char, rsi::kMaxFrameBytes> buffer_{};
  std::uint32_t acknowledged_seen_ = 0;
  JointVector correction_;        // in force
  JointVector model_correction_;  // the model's last wish at full gain
  JointVector fade_;              // what is faded out after a change of the model or a long hold
  double ramp_ = 0;               // 0..1, straight in time
  double fade_ramp_ = 1;          // 0..1, straight in time
  bool refade_ = false;           // the next good cycle fades from what is in force
  bool malformed_before_ = false;
  bool late_before_ = false;
  double broken_ = 0;  // cycles in a row, as the next three
  double unsolved_ = 0;
  double not_following_ = 0;
  int rejected_ = 0;
  int implausible_ = 0;
  std::optional<std::int64_t> delay_;
  std::optional<drivers::TimePoint> received_;
  std::chrono::nanoseconds last_turnaround_{0};
  std::optional<JointVector> last_commanded_;
  std::optional<JointVector> last_expected_;  // commanded and correction of the cycle before
};

}  // namespace truepose::daemon
