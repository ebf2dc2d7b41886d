#pragma once

#include <filesystem>
#include <ostream>

#include "config/config_error.hpp"
#include "core/identify/measurement.hpp"

namespace truepose::config {

/// Reads a measurement file (CSV with a header row, any column order; q1..qN in deg or mm, x,y,z in mm,
/// optional smr, set, sigma, dir1..dirN, time). Throws ConfigError naming file, row and column.
MeasurementData load_measurements(const std::filesystem::path& file, const RobotModel& robot);

/// Writes the same format, every number with the digits that bring it back exactly.
void write_measurements(std::ostream& out, const MeasurementData& data, const RobotModel& robot);

}  // namespace truepose::config
