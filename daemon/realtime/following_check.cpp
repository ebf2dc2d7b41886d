#include "daemon/realtime/following_check.hpp"

#include "daemon/realtime/controller_session.hpp"

namespace truepose::daemon {
namespace {

// So many judgements in a row, a quarter of a second each, that the arm does not follow are believed.
constexpr int kNotFollowing = 2;
// By so many standard deviations a measured correction differs from the sent one before that is believed.
constexpr double kSigmas = 4;

}  // namespace

void FollowingCheck::restart() noexcept {
  effect_.restart();
  not_following_ = 0;
  measured_deg_.fill(std::nullopt);
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

}  // namespace truepose::daemon
