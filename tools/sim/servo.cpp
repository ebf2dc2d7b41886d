#include "tools/sim/servo.hpp"

#include <algorithm>
#include <cmath>

namespace truepose::sim {

Servo::Servo(ServoSetup setup, Seconds cycle)
    : dead_cycles_{static_cast<std::size_t>(setup.dead_time / cycle)},
      dead_part_{setup.dead_time / cycle - static_cast<double>(dead_cycles_)},
      share_(static_cast<Eigen::Index>(setup.lag.size())),
      given_(dead_cycles_ + 2) {
  std::ranges::transform(setup.lag, share_.begin(), [cycle](Seconds lag) {
    return lag > Seconds{0} ? 1 - std::exp(-(cycle / lag)) : 1.0;
  });
}

void Servo::stand_at(const JointVector& q) {
  std::ranges::fill(given_, q);
  position_ = q;
}

const JointVector& Servo::follow(const JointVector& given) {
  newest_ = (newest_ + 1) % given_.size();
  given_[newest_] = given;
  const JointVector due =
      (1 - dead_part_) * given_ago(dead_cycles_) + dead_part_ * given_ago(dead_cycles_ + 1);
  if (share_.size() == 0) {
    position_ = due;
  } else {
    position_ += share_.cwiseProduct(due - position_);
  }
  return position_;
}

const JointVector& Servo::given_ago(std::size_t cycles) const {
  return given_[(newest_ + given_.size() - cycles) % given_.size()];
}

}  // namespace truepose::sim
