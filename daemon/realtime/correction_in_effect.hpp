#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "core/arm/robot_model.hpp"
#include "core/compensate/correction_bounds.hpp"

namespace truepose::daemon {

/// How far an arm may trail its commands, in cycles.
struct ArmLag {
  int dead_cycles = 30;       ///< greatest dead time
  double lag_cycles = 30;     ///< greatest time constant with which it then follows
  double noise_rad = 3.5e-5;  ///< AIPos of a standing arm, and its last decimal: 0.002 deg
};

/// What the actual axes (AIPos) say of the correction that a controller has in effect, while that does not
/// change: the arm goes where the program commands it (ASPos) plus the correction, later by a dead time and
/// with a lag.
///
/// With y the actual axes, w the commanded ones and c the correction, there are a dead time d and a lag T
/// within bounds such that y + T dy/dt = w(t - d) + c. So each cycle gives an interval for c on each axis,
/// and what was seen over several cycles their intersection: a point where the arm stands, wide where it
/// moves fast. Nothing else is assumed for range(). No allocation.
class EffectEvidence {
 public:
  explicit EffectEvidence(const ArmLag& lag) : lag_{lag} {}

  /// Nothing was seen yet, or the correction has changed.
  void restart() noexcept;

  /// @param forward  IPOC since the frame before: a gap restarts the evidence
  void take(const JointVector& commanded, const JointVector& actual, std::uint64_t forward) noexcept;

  /// Corrections that agree with all that was seen; none until a whole dead time has been seen.
  std::optional<CorrectionRange> range() const noexcept;

  /// What the last cycles show of an arm that stands: commanded and actual axes both at rest. Sooner than
  /// range(), on the premise that the arm was not moved by exactly the correction within one dead time
  /// before.
  std::optional<CorrectionRange> at_rest() const noexcept;

  /// Whether the last cycles agree with `correction` on all axes under one and the same lag of the moving
  /// arm. At least two axes must move, or the lag could stand for a correction of the one.
  bool agrees_in_motion(const JointVector& correction) const noexcept;

 private:
  static constexpr int kAxes = 6;
  static constexpr std::size_t kCapacity = 64;  // cycles: more than any dead time
  static constexpr int kJudged = 4;             // cycles that at_rest() and agrees_in_motion() look at
  using Vector = Eigen::Matrix<double, kAxes, 1>;
  struct Cycle {
    Vector commanded, actual;
  };

  const Cycle& back(int cycles) const noexcept {
    return cycles_[(taken_ - 1 - static_cast<std::uint64_t>(cycles)) % kCapacity];
  }
  int seen() const noexcept { return static_cast<int>(std::min<std::uint64_t>(taken_, kCapacity)); }
  void narrow() noexcept;

  ArmLag lag_;
  std::array<Cycle, kCapacity> cycles_{};
  std::uint64_t taken_ = 0;
  std::uint64_t forward_ = 0;
  bool whole_ = false;  // min_ and max_ hold what a whole dead time showed
  Vector min_ = Vector::Zero(), max_ = Vector::Zero();
};

/// The correction in effect at the controller, as far as it is known. It outlives our process. Only a proven
/// value may be the start of a ramp: under absolute corrections any other reply is a jump.
///
/// Known: a range, of one value where the last reply is known to have been taken. Doubtful: that range or
/// zero, because the controller's side may have restarted. Unknown: anything.
class CorrectionInEffect {
 public:
  enum class Knowledge { Known, Doubtful, Unknown };

  CorrectionInEffect() { forget(); }

  bool known() const noexcept { return knowledge_ == Knowledge::Known; }
  bool doubtful() const noexcept { return knowledge_ == Knowledge::Doubtful; }
  /// Where known or doubtful.
  const CorrectionRange& range() const noexcept { return range_; }
  const JointVector& last_sent() const noexcept { return last_sent_; }

  /// A controller of which nothing is known.
  void forget() noexcept;
  /// The controller's side may have restarted, with no correction in effect.
  void doubt() noexcept;
  /// It has not: what was doubted is known.
  void trust() noexcept { knowledge_ = Knowledge::Known; }
  void set(const CorrectionRange& range) noexcept;
  /// As another process left it.
  void resume(const CorrectionRange& range, const JointVector& sent) noexcept;
  /// A reply is on its way: it may be taken or not.
  void sent(const JointVector& correction) noexcept;
  /// The last reply was taken.
  void taken() noexcept;

  /// Decides by what the axes show; until something is proven, nothing changes.
  /// @param step  limit of a correction's change, rad: smaller differences do not matter
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
