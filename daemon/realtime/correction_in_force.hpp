#pragma once

#include "core/compensate/correction_bounds.hpp"
#include "daemon/realtime/effect_evidence.hpp"

namespace truepose::daemon {

/// What the controller has in force, as far as that is known. It outlives our process, and only what is
/// proven may be counted from: under absolute corrections every other reply is a jump.
///
/// Known: a range, of one value where the last reply is known to have been taken. Doubtful: that range or
/// zero, because the controller's side may have begun anew. Unknown: anything.
class CorrectionInForce {
 public:
  enum class Knowledge { Known, Doubtful, Unknown };

  CorrectionInForce() { forget(); }

  Knowledge knowledge() const noexcept { return knowledge_; }
  bool known() const noexcept { return knowledge_ == Knowledge::Known; }
  /// Where known or doubtful.
  const CorrectionRange& range() const noexcept { return range_; }
  const JointVector& last_sent() const noexcept { return last_sent_; }

  /// A controller of which nothing is known.
  void forget() noexcept;
  /// The controller's side may have begun anew, with nothing in force.
  void doubt() noexcept;
  void set(const CorrectionRange& range) noexcept;
  /// As another process left it.
  void resume(const CorrectionRange& range, const JointVector& sent) noexcept;
  /// A reply is on its way: it may be taken or not.
  void sent(const JointVector& correction) noexcept;
  /// The last reply was taken.
  void taken() noexcept;

  /// Decides by what the axes show; until something is proven, nothing changes.
  /// @param step  bound of a correction's change, rad: what is nearer than that need not be told apart
  /// @return whether it is known now
  bool settle(const EffectEvidence& evidence, double step) noexcept;

 private:
  bool settle_doubt(const EffectEvidence& evidence, double step) noexcept;
  bool settle_unknown(const EffectEvidence& evidence, double step) noexcept;

  Knowledge knowledge_ = Knowledge::Unknown;
  CorrectionRange range_;
  JointVector last_sent_;
};

}  // namespace truepose::daemon
