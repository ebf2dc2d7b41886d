#pragma once

#include <filesystem>
#include <ostream>
#include <vector>

#include "config/config_error.hpp"
#include "core/arm/robot_model.hpp"

namespace truepose::config {

/// What a file of joint positions may tell beside them: how well each reaches its target.
inline const std::vector<std::string> kReachColumns{"residual_mm", "residual_deg", "sigma_mm"};

/// Reads joint positions (CSV, columns q1..qN in deg or mm; kReachColumns are passed over). Throws
/// ConfigError naming file, row and column.
std::vector<JointVector> load_joints(const std::filesystem::path& file, const RobotModel& robot);

/// Writes joint positions in the format that load_joints reads.
void write_joints(std::ostream& out, const std::vector<JointVector>& joints, const RobotModel& robot);

}  // namespace truepose::config
