#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstdint>
#include <expected>
#include <string>
#include <vector>

#include "core/kinematics/robot_model.hpp"

namespace truepose {

/// How the tracker sees the reflector on the flange; rough values do. mm, rad.
struct LineOfSight {
  Eigen::Isometry3d X_WB = Eigen::Isometry3d::Identity();
  Eigen::Vector3d p_FS_mm{0, 0, 0};
  Eigen::Vector3d facing_F{0, 0, 1};  ///< direction of the reflector's opening
  double acceptance_rad = 0;          ///< half angle of the cone in which the reflector can be seen
};

struct PoseSamplerOptions {
  int poses = 60;
  std::uint64_t seed = 0;
  double limit_margin_rad = 0;  ///< kept from the limits of revolute joints
  double limit_margin_mm = 10;  ///< kept from the limits of prismatic joints
  double floor_mm =
      300;  ///< no joint origin but the base's, nor the flange or the reflector below this height
  double distinct_rad = 0.05;  ///< two poses differ at least so much in one joint (prismatic: as many metres)
  int candidates = 200000;     ///< tried before giving up
};

/// Random poses that are inside the joint limits, above the floor, seen by the tracker, and distinct. The
/// same options give the same poses on every machine.
///
/// @return the poses in the order in which they were drawn, or one sentence: how many were found, and what
/// most of the
///         others failed on
std::expected<std::vector<JointVector>, std::string> sample_poses(const RobotModel& robot,
                                                                  const LineOfSight& sight,
                                                                  const PoseSamplerOptions& options);

/// Time (s) of a point-to-point motion at full joint speeds: that of the joint that needs longest.
double travel_time_s(const RobotModel& robot, const JointVector& from, const JointVector& to);

/// Orders poses by nearest neighbour in travel time, from `start`.
std::vector<JointVector> order_by_travel(const RobotModel& robot, const JointVector& start,
                                         std::vector<JointVector> poses);

}  // namespace truepose
