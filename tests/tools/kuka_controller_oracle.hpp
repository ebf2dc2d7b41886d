#pragma once

#include <cmath>

#include "core/arm/robot_model.hpp"

/// What a controller of the KR 210 R2700-2 makes of positions: written from the arm's drawing and KUKA's
/// words for S and T, without the code under test.
namespace truepose::oracle {

inline constexpr double kUpperArm_mm = 1150, kForearm_mm = 1220, kForearmOffset_mm = 115, kShoulder_mm = 330;

/// S of joint positions.
inline int status(const JointVector& q) {
  const double lean = q[1] + q[2];  // of the forearm, downwards
  const double wrist_x_mm = kShoulder_mm + kUpperArm_mm * std::cos(q[1]) + kForearm_mm * std::cos(lean) +
                            kForearmOffset_mm * std::sin(lean);
  const bool behind = wrist_x_mm < 0;
  const bool elbow = q[2] >= std::atan2(kForearmOffset_mm, kForearm_mm);
  const bool wrist = q[4] <= 0;
  return (behind ? 1 : 0) + (elbow ? 2 : 0) + (wrist ? 4 : 0);
}

/// T of joint positions.
inline int turn(const JointVector& q) {
  int bits = 0;
  for (Eigen::Index i = 0; i < 6; ++i) bits += q[i] < 0 ? 1 << i : 0;
  return bits;
}

}  // namespace truepose::oracle
