#pragma once

#include <filesystem>
#include <ostream>
#include <string>
#include <string_view>
#include <vector>

#include "core/arm/joint_units.hpp"
#include "core/arm/robot_model.hpp"
#include "core/data/measurement.hpp"

namespace truepose::config {

struct TableReading;

/// A joint position as a file writes it. It reads back as exactly `q` where `q` came from such a text.
std::string joint_field(double q, const Joint& joint);

/// "q1".."qN" for the prefix "q".
std::vector<std::string> joint_column_names(std::string_view prefix, std::size_t count);
std::vector<std::string> joint_column_names(std::string_view prefix, const RobotModel& robot);

/// Further columns of a file of joint positions: how well each position reaches its target.
inline const std::vector<std::string> kReachColumns{"residual_mm", "residual_deg", "sigma_mm"};

/// Reads joint positions (CSV, columns q1..qN in deg or mm; kReachColumns are passed over). Throws
/// ConfigError naming file, row and column.
std::vector<JointVector> load_joints(const std::filesystem::path& file, const RobotModel& robot,
                                     const TableReading* reading = nullptr);

/// Writes joint positions in the format that load_joints reads.
void write_joints(std::ostream& out, const std::vector<JointVector>& joints, const RobotModel& robot);

/// Reads a measurement file (CSV with a header row, any column order; q1..qN in deg or mm, x,y,z in mm,
/// optional smr, set, sigma, excess, dir1..dirN, temp1..tempN in deg C, time, pose, what the flange
/// carried: payload_kg, payload_x, payload_y, payload_z, and how a 6-D target is turned: kTurnColumns). A row
/// whose x, y and z are all 0 is refused, and so are times that measured_time() does not read, that are of
/// several forms or that some rows lack. Throws ConfigError naming file, row and column.
///
/// @param reading  of files that other programs wrote too; null: in this form only
MeasurementData load_measurements(const std::filesystem::path& file, const RobotModel& robot,
                                  const TableReading* reading = nullptr);

/// Writes the same format, every number with the digits that bring it back exactly; an orientation comes back
/// to its last digits.
void write_measurements(std::ostream& out, const MeasurementData& data, const RobotModel& robot);

}  // namespace truepose::config
