#pragma once

#include <filesystem>

#include "config/import/imported_arm.hpp"

namespace truepose::config {

/// Reads the parameters of an arm with ortho-parallel base and spherical wrist (YAML, m and rad, as the
/// packages of ROS-Industrial have them): opw_kinematics_geometric_parameters {a1, a2, b, c1, c2, c3, c4},
/// opw_kinematics_joint_offsets and opw_kinematics_joint_sign_corrections; an angle may be deg(90).
/// Source: Brandstoetter, Angerer, Hofbaur, ARW 2014. Throws ConfigError.
ImportedArm load_opw(const std::filesystem::path& file);

}  // namespace truepose::config
