#pragma once

#include <Eigen/Geometry>
#include <span>
#include <vector>

#include "core/arm/robot_model.hpp"

namespace truepose {

/// A pose as a controller shows it.
struct PoseReading {
  JointVector q;  ///< rad, mm
  Eigen::Isometry3d X_BF = Eigen::Isometry3d::Identity();
};

/// How far an arm stands from a reading.
struct PoseDifference {
  double mm = 0, rad = 0;
};
std::vector<PoseDifference> differences_of(const RobotModel& robot, std::span<const PoseReading> readings);

/// A change at one place of a robot file that explains the readings.
struct PoseExplanation {
  enum class Place { Row, Coupling, Flange, Base };
  Place place = Place::Row;
  int joint = 0;     ///< of a row, counted from 0
  RobotModel fixed;  ///< the arm with the change; of Base: with the flange as it is
  Eigen::Isometry3d X_base =
      Eigen::Isometry3d::Identity();  ///< of Base: the arm's base in the readings' frame
  double rms_mm = 0;                  ///< what then remains, 1 rad counted as 1000 mm
};

/// The changes of one row (sign, quarter turns of theta, a, alpha, d, theta), of a coupling with the joint
/// before, of the flange or of the base that leave at most a third of the difference; best first, without
/// those that leave twice as much as the best.
std::vector<PoseExplanation> explain_differences(const RobotModel& robot,
                                                 std::span<const PoseReading> readings);

}  // namespace truepose
