#include "core/simulate/joint_motion.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace truepose {

JointMotion::JointMotion(const RobotModel& robot, JointVector from, JointVector to, double speed_scale,
                         Seconds ramp)
    : from_{std::move(from)}, to_{std::move(to)} {
  Seconds slowest{0};  // time of the joint that needs longest at its full speed
  for (Eigen::Index i = 0; i < from_.size(); ++i) {
    const double speed = robot.joints[static_cast<std::size_t>(i)].speed * speed_scale;
    slowest = std::max(slowest, Seconds{std::abs(to_[i] - from_[i]) / speed});
  }
  if (slowest <= Seconds{0}) return;

  // s grows by the area under the trapezoid: full speed for `slowest` in all, one ramp of it lost at the two
  // ends.
  const double acceleration = 1.0 / (slowest.count() * ramp.count());
  ramp_ = std::min(ramp, Seconds{std::sqrt(1.0 / acceleration)});
  speed_ = acceleration * ramp_.count();
  duration_ = Seconds{1.0 / speed_} + ramp_;
}

double JointMotion::travelled(Seconds t) const {
  const auto ramped = [this](Seconds since) {
    return 0.5 * speed_ / ramp_.count() * since.count() * since.count();
  };
  if (t < ramp_) return ramped(t);
  if (t > duration_ - ramp_) return 1.0 - ramped(duration_ - t);
  return speed_ * (t - ramp_ / 2).count();
}

JointVector JointMotion::position(Seconds t) const {
  if (t >= duration_) return to_;
  if (t <= Seconds{0}) return from_;
  return from_ + travelled(t) * (to_ - from_);
}

}  // namespace truepose
