#include "daemon/realtime/correction_ramp.hpp"

#include <algorithm>
#include <utility>

namespace truepose::daemon {

double CorrectionRamp::at(bool engaged, double cycles) const noexcept {
  const double step = cycles / cycles_;
  return std::clamp(ramp_ + (engaged ? step : -step), 0.0, 1.0);
}

JointVector CorrectionRamp::advance(bool engaged, double cycles, const JointVector& model,
                                    const JointVector& current) noexcept {
  ramp_ = at(engaged, cycles);
  JointVector wanted = gain() * model;
  if (std::exchange(starts_from_current_, false)) {
    fade_ = current - wanted;
    fade_ramp_ = 0;
  } else {
    fade_ramp_ = std::min(1.0, fade_ramp_ + cycles / cycles_);
  }
  wanted += (1 - smooth(fade_ramp_)) * fade_;
  return wanted;
}

void CorrectionRamp::reset() noexcept {
  ramp_ = 0;
  fade_.setZero();
  fade_ramp_ = 1;
  starts_from_current_ = false;
}

}  // namespace truepose::daemon
