#pragma once

#include <utility>
#include <vector>

#include "core/math/random.hpp"
#include "tests/daemon/plant.hpp"

namespace truepose::test {

/// A program's set points: each axis now stands, now goes at its own speed, by bounded accelerations.
class RobotProgram {
 public:
  /// @param random  outlives the program
  RobotProgram(Random& random, double cycle_s);

  /// @return those of the next cycle, deg
  const Plant::Axes& next();

 private:
  void choose();

  Random& random_;
  double cycle_s_;
  std::vector<std::pair<double, double>> limits_deg_;
  double greatest_deg_s_ = 0, acceleration_deg_s2_ = 0;
  int left_ = 0;
  Plant::Axes position_deg_{10, -80, 90, 20, 45, -30}, speed_deg_s_{}, target_deg_s_{};
};

}  // namespace truepose::test
