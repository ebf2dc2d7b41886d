#include "daemon/realtime/correction_in_effect.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/planted_bug.hpp"

namespace truepose::daemon {

namespace {

// An axis so fast says within a few cycles by how much the arm trails: 0.5 deg/s at 4 ms.
constexpr double kFastRad = 0.002 * kRadPerDeg;

// Of a step: what is left of it is for the noise of the axes.
constexpr double kReach = 0.9;

const JointVector& zero() {
  static const JointVector z = JointVector::Zero(6);
  return z;
}

bool overlap(const CorrectionRange& a, const CorrectionRange& b) {
  return (a.min.cwiseMax(b.min) - a.max.cwiseMin(b.max)).maxCoeff() <= 0;
}

/// Zero may be sent, whatever of the range is in effect.
bool zero_is_near(const CorrectionRange& range, double step) {
  return range.min.minCoeff() >= -kReach * step && range.max.maxCoeff() <= kReach * step;
}

CorrectionRange with_zero(CorrectionRange range) {
  range.include(zero());
  return range;
}

}  // namespace

void EffectEvidence::restart() noexcept {
  taken_ = 0;
  forward_ = 0;
  whole_ = false;
}

void EffectEvidence::take(const JointVector& commanded, const JointVector& actual,
                          std::uint64_t forward) noexcept {
  if (taken_ > 1 && forward != forward_) restart();
  forward_ = forward;
  cycles_[taken_ % kCapacity] = {commanded, actual};
  ++taken_;
  narrow();
}

/// Takes the last cycle's interval into the intersection. Where that becomes empty, the premise is broken:
/// the correction does change, or the arm is no such arm; what was seen so far says nothing.
void EffectEvidence::narrow() noexcept {
  const int window = std::min(lag_.dead_cycles, static_cast<int>(kCapacity) - 2);
  if (seen() < window + 2) return;
  Vector lowest = back(0).commanded, highest = lowest;
  for (int i = 1; i <= window; ++i) {
    lowest = lowest.cwiseMin(back(i).commanded);
    highest = highest.cwiseMax(back(i).commanded);
  }
  const Vector& actual = back(0).actual;
  const Vector still_to_go = (actual - back(1).actual) * lag_.lag_cycles;
  const Vector noise = Vector::Constant(lag_.noise_rad);
  const Vector from = actual + still_to_go.cwiseMin(Vector::Zero()) - highest - noise;
  const Vector to = actual + still_to_go.cwiseMax(Vector::Zero()) - lowest + noise;
  min_ = whole_ ? min_.cwiseMax(from) : from;
  max_ = whole_ ? max_.cwiseMin(to) : to;
  whole_ = true;
  if ((max_ - min_).minCoeff() < 0) restart();
}

std::optional<CorrectionRange> EffectEvidence::range() const noexcept {
  if (!whole_) return std::nullopt;
  return CorrectionRange{min_, max_};
}

std::optional<CorrectionRange> EffectEvidence::at_rest() const noexcept {
  if (seen() < kJudged) return std::nullopt;
  for (int i = 1; i < kJudged; ++i) {
    if ((back(i).commanded - back(0).commanded).cwiseAbs().maxCoeff() > lag_.noise_rad) return std::nullopt;
  }
  const Vector difference = back(0).actual - back(0).commanded;
  const Vector still_to_go = (back(0).actual - back(kJudged - 1).actual) * (lag_.lag_cycles / (kJudged - 1));
  const Vector noise = Vector::Constant(lag_.noise_rad);
  return CorrectionRange{difference + still_to_go.cwiseMin(Vector::Zero()) - noise,
                         difference + still_to_go.cwiseMax(Vector::Zero()) + noise};
}

bool EffectEvidence::agrees_in_motion(const JointVector& correction) const noexcept {
  if (seen() < kJudged) return false;
  double least_lag = 0, greatest_lag = lag_.dead_cycles + lag_.lag_cycles;
  std::array<bool, kAxes> fast{};
  for (int i = 0; i + 1 < kJudged; ++i) {
    const Vector motion = back(i).commanded - back(i + 1).commanded;
    const Vector behind = back(i).commanded + correction - back(i).actual;
    for (int axis = 0; axis < kAxes; ++axis) {
      const double speed = motion[axis];
      if (std::abs(speed) * (lag_.dead_cycles + lag_.lag_cycles) < lag_.noise_rad) {  // stands
        if (std::abs(behind[axis]) > 2 * lag_.noise_rad) return false;
        continue;
      }
      // behind = lag * speed, to within the noise
      const double a = (behind[axis] - lag_.noise_rad) / speed, b = (behind[axis] + lag_.noise_rad) / speed;
      least_lag = std::max(least_lag, std::min(a, b));
      greatest_lag = std::min(greatest_lag, std::max(a, b));
      fast[static_cast<std::size_t>(axis)] |= std::abs(speed) > kFastRad;
    }
  }
  return least_lag <= greatest_lag &&
         std::ranges::count(fast, true) >= (planted("a new start that is judged on one axis") ? 1 : 2);
}

void CorrectionInEffect::forget() noexcept {
  knowledge_ = Knowledge::Unknown;
  range_ = CorrectionRange::of(zero());
  last_sent_ = zero();
}

void CorrectionInEffect::doubt() noexcept {
  if (known()) knowledge_ = Knowledge::Doubtful;
}

void CorrectionInEffect::set(const CorrectionRange& range) noexcept {
  knowledge_ = Knowledge::Known;
  range_ = range;
  last_sent_ = range.max;
}

void CorrectionInEffect::resume(const CorrectionRange& range, const JointVector& sent) noexcept {
  set(range);
  last_sent_ = sent;
}

void CorrectionInEffect::sent(const JointVector& correction) noexcept {
  range_.include(correction);
  if (planted("a limit from the last datagram, not from what is in effect"))
    range_ = CorrectionRange::of(correction);
  last_sent_ = correction;
}

void CorrectionInEffect::taken() noexcept {
  if (known()) range_ = CorrectionRange::of(last_sent_);
}

bool CorrectionInEffect::settle(const EffectEvidence& evidence, double step) noexcept {
  if (planted("zero at the start of each session")) set(CorrectionRange::of(zero()));
  if (knowledge_ == Knowledge::Doubtful) settle_doubt(evidence, step);
  if (knowledge_ == Knowledge::Unknown) settle_unknown(evidence, step);
  return known();
}

bool CorrectionInEffect::settle_doubt(const EffectEvidence& evidence, double step) noexcept {
  const CorrectionRange either = with_zero(range_);
  if (either.within_reach(kReach * step)) {
    set(either);
    return true;
  }
  // Nothing in effect any more is seen at once. What is as before is not: for a dead time the arm shows that
  // after a new start too.
  const auto seen = evidence.range();
  const JointVector held = (range_.min + range_.max) / 2;
  const bool as_before = seen && overlap(*seen, range_),
             restarted = seen && overlap(*seen, CorrectionRange::of(zero()));
  if (seen && !as_before && !restarted) {
    forget();
  } else if (seen && !restarted) {
    knowledge_ = Knowledge::Known;
  } else if (seen && !as_before) {
    set(CorrectionRange::of(zero()));
  } else if (const auto standing = evidence.at_rest(); standing && zero_is_near(*standing, step)) {
    set(with_zero(*standing));
  } else {
    const bool moves_as_before = evidence.agrees_in_motion(held),
               moves_as_restarted = evidence.agrees_in_motion(zero());
    if (moves_as_restarted && !moves_as_before) set(CorrectionRange::of(zero()));
    if (seen && moves_as_before && !moves_as_restarted) knowledge_ = Knowledge::Known;
  }
  return known();
}

bool CorrectionInEffect::settle_unknown(const EffectEvidence& evidence, double step) noexcept {
  if (const auto seen = evidence.range(); seen && seen->within_reach(kReach * step)) {
    set(*seen);
  } else if (const auto standing = evidence.at_rest(); standing && zero_is_near(*standing, step)) {
    set(with_zero(*standing));
  } else if (evidence.agrees_in_motion(zero())) {
    set(CorrectionRange::of(zero()));
  }
  return known();
}

}  // namespace truepose::daemon
