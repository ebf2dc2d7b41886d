#pragma once

#include <Eigen/Geometry>
#include <string>

#include "core/quality/path_accuracy.hpp"

namespace truepose::report {

/// The program GLUING in the plane z = 500 mm: 400 mm along x, then 200 mm along y, at 0.25 m/s, the arm two
/// samples behind. Along the path the reflector is off by 0.05 mm with the correction and 1.5 mm without it;
/// at its two points by 0.1 and 0.2 mm, and 2 and 1 mm without it.
ProductionPath sample_path();

/// The path file of it, from a flange that is not turned.
std::string path_file_of(const ProductionPath& path, const Eigen::Isometry3d& X_WB,
                         const Eigen::Vector3d& p_FS_mm);

}  // namespace truepose::report
