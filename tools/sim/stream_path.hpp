#pragma once

#include <cstddef>
#include <vector>

#include "core/arm/robot_model.hpp"
#include "core/simulate/joint_motion.hpp"

namespace truepose::sim {

/// The programmed path of the RSI program: point to point through `points`, in a loop, from the first one.
class StreamPath {
 public:
  /// @param points  at least one; a single one is stood at
  StreamPath(RobotModel nominal, std::vector<JointVector> points, double speed_scale);

  JointVector position() const;
  void advance(Seconds dt);
  bool moving() const { return points_.size() > 1; }

 private:
  JointMotion leg() const;

  RobotModel nominal_;
  std::vector<JointVector> points_;
  double speed_scale_;
  std::size_t from_ = 0;
  Seconds on_leg_{0};
  JointMotion motion_;
};

}  // namespace truepose::sim
