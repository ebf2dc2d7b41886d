#include "daemon/realtime/correction_in_force.hpp"

namespace truepose::daemon {
namespace {

// Of a step: what is left of it is for the noise of the axes.
constexpr double kReach = 0.9;

const JointVector& zero() {
  static const JointVector z = JointVector::Zero(6);
  return z;
}

bool overlap(const CorrectionRange& a, const CorrectionRange& b) {
  return (a.min.cwiseMax(b.min) - a.max.cwiseMin(b.max)).maxCoeff() <= 0;
}

/// Zero may be sent, whatever of the range is in force.
bool zero_is_near(const CorrectionRange& range, double step) {
  return range.min.minCoeff() >= -kReach * step && range.max.maxCoeff() <= kReach * step;
}

CorrectionRange with_zero(CorrectionRange range) {
  range.include(zero());
  return range;
}

}  // namespace

void CorrectionInForce::forget() noexcept {
  knowledge_ = Knowledge::Unknown;
  range_ = CorrectionRange::of(zero());
  last_sent_ = zero();
}

void CorrectionInForce::doubt() noexcept {
  if (known()) knowledge_ = Knowledge::Doubtful;
}

void CorrectionInForce::set(const CorrectionRange& range) noexcept {
  knowledge_ = Knowledge::Known;
  range_ = range;
  last_sent_ = range.max;
}

void CorrectionInForce::resume(const CorrectionRange& range, const JointVector& sent) noexcept {
  set(range);
  last_sent_ = sent;
}

void CorrectionInForce::sent(const JointVector& correction) noexcept {
  range_.include(correction);
  last_sent_ = correction;
}

void CorrectionInForce::taken() noexcept {
  if (known()) range_ = CorrectionRange::of(last_sent_);
}

bool CorrectionInForce::settle(const EffectEvidence& evidence, double step) noexcept {
  if (knowledge_ == Knowledge::Doubtful) settle_doubt(evidence, step);
  if (knowledge_ == Knowledge::Unknown) settle_unknown(evidence, step);
  return known();
}

bool CorrectionInForce::settle_doubt(const EffectEvidence& evidence, double step) noexcept {
  const CorrectionRange either = with_zero(range_);
  if (either.within_reach(kReach * step)) {
    set(either);
    return true;
  }
  // Nothing in force any more is seen at once. What is as before is not: for a dead time the arm shows that
  // after a new start too.
  const auto seen = evidence.range();
  const JointVector held = (range_.min + range_.max) / 2;
  const bool as_before = seen && overlap(*seen, range_),
             anew = seen && overlap(*seen, CorrectionRange::of(zero()));
  if (seen && !as_before && !anew) {
    forget();
  } else if (seen && !anew) {
    knowledge_ = Knowledge::Known;
  } else if (seen && !as_before) {
    set(CorrectionRange::of(zero()));
  } else if (const auto standing = evidence.at_rest(); standing && zero_is_near(*standing, step)) {
    set(with_zero(*standing));
  } else {
    const bool moves_as_before = evidence.agrees_in_motion(held),
               moves_anew = evidence.agrees_in_motion(zero());
    if (moves_anew && !moves_as_before) set(CorrectionRange::of(zero()));
    if (seen && moves_as_before && !moves_anew) knowledge_ = Knowledge::Known;
  }
  return known();
}

bool CorrectionInForce::settle_unknown(const EffectEvidence& evidence, double step) noexcept {
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
