#include "tests/daemon/robot_program.hpp"

#include <algorithm>
#include <cmath>

#include "core/math/angles.hpp"
#include "tests/daemon/stream_rig.hpp"

namespace truepose::test {

RobotProgram::RobotProgram(Random& random, double cycle_s) : random_{random}, cycle_s_{cycle_s} {
  for (const Joint& joint : daemon::nominal_arm().joints)
    limits_deg_.push_back({joint.min * kDegPerRad, joint.max * kDegPerRad});
  greatest_deg_s_ = random.uniform() < 0.3 ? 5 : 200;
}

const Plant::Axes& RobotProgram::next() {
  if (--left_ <= 0) choose();
  for (std::size_t i = 0; i < 6; ++i) {
    if (position_deg_[i] < limits_deg_[i].first + 10) target_deg_s_[i] = std::abs(target_deg_s_[i]);
    if (position_deg_[i] > limits_deg_[i].second - 10) target_deg_s_[i] = -std::abs(target_deg_s_[i]);
    const double most = acceleration_deg_s2_ * cycle_s_;
    speed_deg_s_[i] += std::clamp(target_deg_s_[i] - speed_deg_s_[i], -most, most);
    position_deg_[i] = std::clamp(position_deg_[i] + speed_deg_s_[i] * cycle_s_, limits_deg_[i].first + 1,
                                  limits_deg_[i].second - 1);
  }
  return position_deg_;
}

void RobotProgram::choose() {
  left_ = static_cast<int>(random_.uniform() * 0.8 / cycle_s_);
  acceleration_deg_s2_ = std::pow(10, 1.5 + 2 * random_.uniform());
  const bool stands = random_.uniform() < 0.4, one_axis = random_.uniform() < 0.2;
  const auto chosen = static_cast<std::size_t>(random_.uniform() * 6);
  for (std::size_t i = 0; i < 6; ++i) {
    const bool moves = !stands && (one_axis ? i == chosen : random_.uniform() < 0.8);
    target_deg_s_[i] = moves ? greatest_deg_s_ * (2 * random_.uniform() - 1) : 0;
  }
}

}  // namespace truepose::test
