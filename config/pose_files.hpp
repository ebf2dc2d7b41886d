#pragma once

#include <filesystem>
#include <ostream>
#include <vector>

#include "config/config_error.hpp"
#include "core/kinematics/robot_model.hpp"

namespace truepose::config {

/// Reads joint positions (CSV, columns q1..qN in deg or mm). Throws ConfigError naming file, row and column.
std::vector<JointVector> load_joints(const std::filesystem::path& file, const RobotModel& robot);

/// Reads flange poses in the robot base frame (CSV, columns x,y,z in mm and KUKA's a,b,c in deg).
std::vector<Eigen::Isometry3d> load_poses(const std::filesystem::path& file);

/// Writes joint positions in the format that load_joints reads.
void write_joints(std::ostream& out, const std::vector<JointVector>& joints, const RobotModel& robot);

}  // namespace truepose::config
