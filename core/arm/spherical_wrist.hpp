#pragma once

#include <array>
#include <expected>
#include <string>

#include "core/arm/robot_model.hpp"

namespace truepose {

/// Closed-form inverse of a six-axis arm whose last three axes meet in a point and whose axes 2 and 3 are
/// parallel.
///
/// It holds for nominal arms only: a calibrated arm has no exact common point, and is solved by Newton from
/// here.
class SphericalWristInverse {
 public:
  /// @return the solver, or one sentence on which condition of the closed form the arm does not meet.
  static std::expected<SphericalWristInverse, std::string> of(const RobotModel& robot);

  /// The solutions of one flange pose: shoulder front or back, elbow up or down, wrist flipped or not.
  struct Solutions {
    std::array<JointVector, 8> q;
    int count = 0;  ///< 0 where the pose is out of reach, at most 8
  };

  /// All solutions of the pose, joint limits not regarded, each angle within (-pi, pi] of the joint's q = 0.
  /// In the wrist singularity (axes 4 and 6 in line) axis 4 keeps the value in `q_near`.
  Solutions all(const Eigen::Isometry3d& X_BF, const JointVector& q_near) const;

  /// The solution nearest to `q_near` in the joint limits (turns of 2 pi added where the limits allow).
  std::expected<JointVector, std::string> nearest(const Eigen::Isometry3d& X_BF,
                                                  const JointVector& q_near) const;

 private:
  explicit SphericalWristInverse(RobotModel robot);
  RobotModel robot_;
};

}  // namespace truepose
