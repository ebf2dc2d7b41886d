#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/arm/robot_model.hpp"

namespace truepose::record {

/// An arm as documents show it, with the keys of a robot file (mm, deg, deg/s, kg).
struct ArmJoint {
  /// In a document a mass follows its centre.
  struct Mass {
    LinkMass mass;
  };
  Joint joint;
  std::optional<Mass> mass;
};
struct Arm {
  std::string name;
  std::vector<ArmJoint> joints;
  std::vector<JointCoupling> coupling;
  Eigen::Isometry3d X_flange = Eigen::Isometry3d::Identity();
  std::optional<LinkMass> payload;
  Eigen::Vector3d gravity_B{0, 0, -1};

  static Arm of(const RobotModel& robot);
  /// Accelerations are not known.
  RobotModel robot() const;
};

}  // namespace truepose::record
