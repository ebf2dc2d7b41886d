#pragma once

#include <boost/json/fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "core/arm/robot_model.hpp"

namespace truepose::record {

/// An arm as documents show it.
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

/// The geometry, limits and masses of an arm as a robot file says them (mm, deg, deg/s, kg), with the same
/// keys. JSON being YAML too, its text is a robot file.
boost::json::object arm_document(const RobotModel& robot);

/// Joint positions, deg (mm for a prismatic joint).
boost::json::array joints_json(const JointVector& q, const RobotModel& robot);

}  // namespace truepose::record
