#pragma once

#include <Eigen/Geometry>
#include <filesystem>

#include "config/text_file.hpp"
#include "core/arm/robot_model.hpp"
#include "core/quality/path_accuracy.hpp"

namespace truepose::config {

/// By what a path is judged.
struct PathFrame {
  Eigen::Isometry3d X_WB;   ///< the robot's base in the tracker's frame, as it was calibrated
  Eigen::Vector3d p_FS_mm;  ///< the reflector
  RobotModel nominal;       ///< the data sheet's arm
};

/// Reads what a simulated controller recorded of a production program (CSV with a header row, any column
/// order; truepose-sim --path-file): `time_s` (never falling), `program` (a name), `point` (1 where the
/// program stands at a point, else 0), `gain_percent` (100 at most), the flange of the data sheet's arm at
/// the set points flange_x_mm.., flange_a_deg.. (robot's base, KUKA's angles), and the reflector in the
/// tracker's frame, with_x_mm.. and without_x_mm...
///
/// From the columns set_a1_deg.., correction_a1_deg.. and actual_a1_deg.. of each axis, where the file has
/// them, the lag of the drives is identified and applied to the wanted path. A file without them has no lag.
/// @return the samples; of several programs all names, with commas between them
/// Throws ConfigError naming file, row and column.
ProductionPath load_production_path(const std::filesystem::path& file, const PathFrame& frame);

}  // namespace truepose::config
