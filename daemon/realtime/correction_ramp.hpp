#pragma once

#include "core/arm/robot_model.hpp"

namespace truepose::daemon {

/// Leads the correction from nothing to all that the model asks for and back, and from what is in effect to
/// another model's, without a kink. Straight in the controller's cycles, smooth in the result.
class CorrectionRamp {
 public:
  /// @param cycles  of a whole ramp
  /// @param axes    of the correction, which is nothing at first
  CorrectionRamp(int cycles, Eigen::Index axes) : cycles_{cycles}, fade_{JointVector::Zero(axes)} {}

  /// Whether the next cycles give the model a part in the correction.
  bool asks_model(bool engaged, double cycles) const noexcept { return at(engaged, cycles) > 0; }

  /// What to send so many cycles on.
  /// @param model    correction that the model asks for; of no effect where it is not asked
  /// @param current  what was sent last
  JointVector advance(bool engaged, double cycles, const JointVector& model,
                      const JointVector& current) noexcept;

  /// The next advance() goes out from what was sent last, whatever the model asks for then.
  void start_from_current() noexcept { starts_from_current_ = true; }
  /// Nothing is in effect.
  void reset() noexcept;

  double gain() const noexcept { return smooth(ramp_); }  ///< the model's part, 0..1
  bool full() const noexcept { return ramp_ == 1; }
  bool whole() const noexcept { return full() && fade_ramp_ == 1; }  ///< nothing else is faded out any more
  bool out() const noexcept { return ramp_ == 0 && (fade_ramp_ == 1 || fade_.isZero(0)); }

 private:
  double at(bool engaged, double cycles) const noexcept;
  // Begins and ends without a kink, so that a ramp does not jerk the arm.
  static double smooth(double x) noexcept { return x * x * (3 - 2 * x); }

  int cycles_;
  double ramp_ = 0;       // 0..1
  JointVector fade_;      // what is faded out
  double fade_ramp_ = 1;  // 0..1
  bool starts_from_current_ = false;
};

}  // namespace truepose::daemon
