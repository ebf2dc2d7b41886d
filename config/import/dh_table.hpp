#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "config/import/imported_arm.hpp"

namespace truepose::config {

/// Standard: Rz(theta) Tz(d) Tx(a) Rx(alpha). Modified (Craig): Rx(alpha) Tx(a) Rz(theta) Tz(d).
enum class DhConvention { Standard, Modified };

/// Units of the columns without a unit in their name.
struct DhUnits {
  double mm = 1;   ///< of a length: 1, 10 or 1000
  double rad = 1;  ///< of an angle: 1 for rad, kRadPerDeg for deg
};

/// "mm,deg" or "m,rad"; nothing where it is none of these. A length may be mm, cm or m.
std::optional<DhUnits> dh_units(std::string_view text);

/// Reads a DH table (CSV; other separators and decimal commas as in a measurement file), one row a joint: a
/// (or r), alpha, d, theta (or offset), and where they are given beta (modified alone), sign, min, max,
/// speed, acceleration, type (revolute or prismatic). A unit stands in a column's name, "a (mm)", "alpha
/// [deg]", "d_m", or is given. Limits and speeds of a revolute joint have the angles' unit. Rows "flange" at
/// the end of a modified table lead from the last joint to the flange. Throws ConfigError: a unit is not
/// said; a column is missing or unknown.
ImportedArm load_dh_table(const std::filesystem::path& file, DhConvention convention,
                          const std::optional<DhUnits>& units);

/// The arm as such a table in mm and deg, which load_dh_table() reads back to the same forward kinematics. A
/// standard table has no beta and no flange of its own. Throws ConfigError where the arm needs one of them.
std::string dh_table_text(const RobotModel& robot, DhConvention convention);

/// The modified table with its columns in RoboDK's order: alpha, a, theta, d, then Hayati's beta and the
/// sense. Reads back as such a table too.
std::string robodk_table_text(const RobotModel& robot);

}  // namespace truepose::config
