// The part of StreamCycle that looks at the arm: where it is, and whether it does what the replies say.
#include "core/planted_bug.hpp"
#include "daemon/realtime/stream_cycle.hpp"

namespace truepose::daemon {
namespace {

// No axis moves so far in a cycle of 12 ms: 220 deg/s are 2.6 deg.
constexpr double kGreatestMotionRad = 3 * kRadPerDeg;
// So many implausible frames in a row are believed after all.
constexpr int kImplausibleFrames = 10;

}  // namespace

std::optional<JointVector> StreamCycle::commanded_axes(const rsi::RobotFrame& frame) const noexcept {
  if (sends_aspos_) {
    if (!frame.aspos_rad) return std::nullopt;
    return vector_of(*frame.aspos_rad);
  }
  if (!frame.aipos_rad) return std::nullopt;
  return vector_of(*frame.aipos_rad) - correction_;
}

/// Whether the arm can have moved here from the frame before.
bool StreamCycle::plausible(const JointVector& commanded, const FrameVerdict& verdict) noexcept {
  const bool far = last_commanded_ && (commanded - *last_commanded_).cwiseAbs().maxCoeff() >
                                          kGreatestMotionRad * static_cast<double>(verdict.elapsed);
  implausible_ = far ? implausible_ + 1 : 0;
  if (!far) return true;
  following_.restart();
  if (implausible_ < kImplausibleFrames) return false;
  implausible_ = 0;
  ramp_.start_from_current();
  return true;
}

/// Checks that our replies arrive, that the arm follows them, and that it is the configured arm.
void StreamCycle::watch(const rsi::RobotFrame& frame, const FrameVerdict& verdict,
                        drivers::TimePoint received) noexcept {
  raise(missing_.take(frame, verdict.elapsed));
  raise(late_replies_.take(verdict, received));
  status_.counters.late += verdict.late;
  if (late_replies_.began()) emit({.kind = StreamEventKind::RepliesLate, .value = verdict.late});
  if (status_.program_stopped) {
    following_.restart();
  } else {
    moved_ = Moved{frame, correction_, verdict.elapsed};
  }
  look_at_arm(frame, verdict.elapsed);
}

/// Half a second of cycles is judged: it may as well be done after the reply. Where nothing is or is to be
/// corrected, there is nothing to follow, but the arm's lag to learn.
void StreamCycle::watch_effect() noexcept {
  if (moved_) {
    const auto found = following_.take(moved_->frame, moved_->correction, moved_->elapsed);
    if ((wanted() || !at_rest()) && !planted("a correction that moves nothing is not noticed")) raise(found);
  }
  moved_.reset();
}

/// A program that is corrected while it works has tools and bases of its own, by which RIst tells no more
/// which arm it is: there it is looked at where the session begins, before anything is in effect.
void StreamCycle::look_at_arm(const rsi::RobotFrame& frame, std::uint64_t elapsed) noexcept {
  if (engagement() == Engagement::Armed && arm_known_) return;
  const std::optional<FoundFault> found = arm_check_.arm(frame, elapsed);
  arm_known_ = frame.rist && !found;
  raise(found);
}

}  // namespace truepose::daemon
