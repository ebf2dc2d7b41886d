#pragma once

#include "core/arm/robot_model.hpp"
#include "core/math/angles.hpp"

namespace truepose {

/// What a correction of the stream may be. All angles rad (mm for a prismatic axis).
struct CorrectionBounds {
  double max_step = 0;      ///< greatest change of an axis from one cycle to the next
  double max_total = 0;     ///< greatest correction of an axis
  JointVector min, max;     ///< joint limits, one per axis; infinite = none
  double limit_margin = 0;  ///< commanded + correction stays this far inside the limits
  /// Grid of the wire (six decimals of a degree). A bounded correction lies on it, so that what is sent is
  /// what was bounded.
  double resolution = 1e-6 * kRadPerDeg;
};

/// What may be in effect at the controller, axis by axis: one value where its last reply is known to have
/// been taken.
struct CorrectionRange {
  JointVector min, max;

  static CorrectionRange of(const JointVector& correction) { return {correction, correction}; }
  /// Whether one correction is within `step` of all of it, on every axis.
  bool within_reach(double step) const noexcept { return (max - min).maxCoeff() <= 2 * step; }
  void include(const JointVector& correction) noexcept {
    min = min.cwiseMin(correction);
    max = max.cwiseMax(correction);
  }
};

/// The bounds that changed a correction.
struct CorrectionClamps {
  bool step = false;
  bool total = false;
  bool limit = false;
  bool not_finite = false;  ///< a number was NaN or infinite, or sizes differ: the last correction is held

  /// True where the arm does not get what it should.
  bool broken() const { return step || total || limit || not_finite; }
};

struct BoundedCorrection {
  JointVector correction;
  CorrectionClamps clamps;
};

/// The one gate between every wish and the wire.
///
/// The result is finite and never further than `max_step` per axis from anything in `in_effect`: this comes
/// before every other bound, so the total and the limits are approached by steps where what is in effect
/// breaks them. Zero is always allowed: where the program itself is beyond a limit, the correction is only
/// kept from going further out. Where no correction is within a step of all of `in_effect`, the result is its
/// middle.
///
/// A correction beyond the total is made smaller as a whole. Where the arm is nearly stretched, axes 2 and 3
/// are corrected against each other: with one of them cut off alone, the arm would be led further off than
/// without any correction.
///
/// @param wanted     correction that the model asks for
/// @param in_effect  what the controller may have in effect
/// @param commanded  joint positions that the robot program commands, without any correction
BoundedCorrection bound_correction(const JointVector& wanted, const CorrectionRange& in_effect,
                                   const JointVector& commanded, const CorrectionBounds& bounds) noexcept;

}  // namespace truepose
