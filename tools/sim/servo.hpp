#pragma once

#include <chrono>
#include <cstddef>
#include <vector>

#include "core/arm/robot_model.hpp"
#include "core/simulate/joint_motion.hpp"

namespace truepose::sim {

struct ServoSetup {
  Seconds dead_time{0};      ///< from a set point to the first motion
  std::vector<Seconds> lag;  ///< time constant of each axis' first-order lag; none follows at once
};

/// The drives: where the axes are for what they are given, cycle by cycle of the controller.
class Servo {
 public:
  Servo(ServoSetup setup, Seconds cycle);

  /// One cycle. @return where the axes are
  const JointVector& follow(const JointVector& given);
  void stand_at(const JointVector& q);
  const JointVector& position() const { return position_; }

 private:
  const JointVector& given_ago(std::size_t cycles) const;

  std::size_t dead_cycles_;         // whole ones
  double dead_part_;                // of one more
  JointVector share_;               // of its way that an axis goes in a cycle; empty: all of it
  std::vector<JointVector> given_;  // a ring
  std::size_t newest_ = 0;
  JointVector position_;
};

}  // namespace truepose::sim
