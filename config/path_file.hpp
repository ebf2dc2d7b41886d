#pragma once

#include <filesystem>

#include "config/text_file.hpp"
#include "core/judge/path_accuracy.hpp"

namespace truepose::config {

/// Reads what a simulated controller recorded of a production program (CSV with a header row, any column
/// order; truepose-sim --path-file): `time_s` (never falling), `program` (a name), `point` (1 where the
/// program stands at a point, else 0), `gain_percent` (100 at most) and the positions wanted_x_mm,
/// wanted_y_mm, wanted_z_mm, with_x_mm.. and without_x_mm.. in the robot's base frame.
///
/// @return the samples; of several programs all names, with commas between them
/// Throws ConfigError naming file, row and column.
ProductionPath load_production_path(const std::filesystem::path& file);

}  // namespace truepose::config
