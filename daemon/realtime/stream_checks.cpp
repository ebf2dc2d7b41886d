#include "daemon/realtime/stream_checks.hpp"

#include <Eigen/Geometry>
#include <chrono>

#include "core/arm/forward.hpp"
#include "daemon/realtime/controller_session.hpp"

namespace truepose::daemon {

namespace {

// KR C2 counts cycles, all others milliseconds.
constexpr std::uint64_t kCountsCycles = 1;

// So many judgements in a row, a quarter of a second each, that the arm does not follow are believed.
constexpr int kNotFollowing = 2;
// By so many standard deviations a measured correction differs from the sent one before that is believed.
constexpr double kSigmas = 4;

// A reply sent so soon was in time, and datagrams so close together come out of a backlog.
constexpr std::chrono::milliseconds kInTime{1};

/// Simulators of the robot's side fill it with zeros: no arm has its flange in its foot.
bool is_blank(const rsi::CartesianPose& pose) { return pose.x_mm == 0 && pose.y_mm == 0 && pose.z_mm == 0; }

}  // namespace

ArmCheck::ArmCheck(const RobotModel& nominal, std::chrono::milliseconds cycle, double max_deviation_mm)
    : nominal_{nominal},
      cycle_ms_{static_cast<std::uint64_t>(cycle.count())},
      second_cycles_{1000.0 / static_cast<double>(cycle.count())},
      max_deviation_mm_{max_deviation_mm} {}

std::optional<FoundFault> ArmCheck::cycle(std::uint64_t step) const noexcept {
  if (step == 0 || step == cycle_ms_ || step == kCountsCycles) return std::nullopt;
  return FoundFault{StreamFault::WrongCycle,
                    {.value = static_cast<double>(step), .limit = static_cast<double>(cycle_ms_)}};
}

std::optional<FoundFault> ArmCheck::arm(const rsi::RobotFrame& frame, std::uint64_t elapsed) noexcept {
  wait_ -= static_cast<double>(elapsed);
  // Counted from the last look: the first frame that shows the arm is looked at, whenever it comes.
  if (wait_ > 0 || !frame.rist || is_blank(*frame.rist) || !frame.aipos_rad) return std::nullopt;
  wait_ = second_cycles_;
  const Eigen::Vector3d p_BF_mm = forward_kinematics(nominal_, vector_of(*frame.aipos_rad)).translation();
  const double off_mm =
      (Eigen::Vector3d{frame.rist->x_mm, frame.rist->y_mm, frame.rist->z_mm} - p_BF_mm).norm();
  if (off_mm <= max_deviation_mm_) return std::nullopt;
  return FoundFault{StreamFault::WrongArm, {.value = off_mm, .limit = max_deviation_mm_}};
}

MissingElements::MissingElements(const rsi::EthernetConfig& ethernet, double limit_cycles) noexcept
    : limit_cycles_{limit_cycles} {
  for (Watched& watched : watched_) watched.sent = ethernet.sends(watched.element);
}

void MissingElements::restart() noexcept {
  for (Watched& watched : watched_) watched.missing_cycles = 0;
}

std::optional<FoundFault> MissingElements::take(const rsi::RobotFrame& frame,
                                                std::uint64_t elapsed) noexcept {
  const std::array<bool, 3> there{frame.delay.has_value(), frame.aipos_rad.has_value(),
                                  frame.rist.has_value()};
  std::optional<FoundFault> missing;
  for (std::size_t i = 0; i < watched_.size(); ++i) {
    Watched& watched = watched_[i];
    watched.missing_cycles = there[i] ? 0 : watched.missing_cycles + static_cast<double>(elapsed);
    if (!missing && watched.sent && watched.missing_cycles >= limit_cycles_)
      missing = FoundFault{StreamFault::NotSent, {.element = watched.element}};
  }
  return missing;
}

void FollowingCheck::restart() noexcept {
  effect_.restart();
  not_following_ = 0;
  measured_deg_.fill(std::nullopt);
}

void FollowingCheck::forget() noexcept {
  restart();
  effect_.forget();
}

std::optional<FoundFault> FollowingCheck::take(const rsi::RobotFrame& frame, const JointVector& correction,
                                               std::uint64_t elapsed) noexcept {
  if (!frame.aspos_rad || !frame.aipos_rad) {
    restart();
    return std::nullopt;
  }
  if (!effect_.take(vector_of(*frame.aspos_rad), correction, vector_of(*frame.aipos_rad), elapsed))
    return std::nullopt;
  const EffectWatch::Vector uncertain = kSigmas * effect_.sigma();
  // The axis of which it is surest.
  Eigen::Index worst = 0;
  const double surest =
      (effect_.missing().cwiseAbs().array() / (uncertain.array() + tolerance_rad_)).maxCoeff(&worst);
  const bool follows = surest <= 1;
  not_following_ = follows ? 0 : not_following_ + 1;
  for (Eigen::Index i = 0; i < EffectWatch::kAxes; ++i) {
    auto& measured_deg = measured_deg_[static_cast<std::size_t>(i)];
    measured_deg.reset();
    if (uncertain[i] <= tolerance_rad_) measured_deg = (correction[i] + effect_.missing()[i]) * kDegPerRad;
  }
  if (not_following_ < kNotFollowing) return std::nullopt;
  const double sent = effect_.sent()[worst], measured = sent + effect_.missing()[worst];
  return FoundFault{StreamFault::NotFollowing,
                    {.axis = static_cast<int>(worst) + 1,
                     .value = measured * kDegPerRad,
                     .limit = sent * kDegPerRad,
                     .uncertain = uncertain[worst] * kDegPerRad}};
}

std::optional<FoundFault> LateReplies::take(const ControllerSession::FrameVerdict& verdict,
                                            drivers::TimePoint received) noexcept {
  believed_ = (believed_ && !verdict.settled) || verdict.taken;
  const bool late = verdict.late > 0;
  began_ = late && !late_before_;
  late_before_ = late;
  const bool sent_in_time =
      verdict.elapsed == 1 && received_ && turnaround_ < kInTime && received - *received_ > kInTime;
  if (late) {
    rejected_ = sent_in_time ? rejected_ + 1 : 0;
  } else if (!verdict.missed) {
    rejected_ = 0;
  }
  if (late && !believed_ && rejected_ >= rejected_cycles_)
    return FoundFault{StreamFault::RepliesRejected, {}};
  return std::nullopt;
}

}  // namespace truepose::daemon
