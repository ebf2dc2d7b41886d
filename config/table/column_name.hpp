#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace truepose::config {

/// What the name of a column in another program's file says.
struct ColumnName {
  std::string name;  ///< as truepose calls it ("q1", "x"); empty: not known
  std::string unit;  ///< as unit_word() has it; empty: not stated. Also of a name that is not known
};

/// "A1 (deg)", "J1", "joint_1", "AIPos.A1" as q1 in deg; "X [mm]", "pos_x_mm" as x; names of truepose in any
/// case as they are. Two more families stand for what is converted first: qw..qz of a quaternion, and
/// roll, pitch, yaw; E1.. are e1..
ColumnName column_name(std::string_view header);

/// A word for a unit as truepose has it: "Grad" as "deg"; empty: no unit. Besides deg, rad, gon, mm, cm, m,
/// um and inch there are units that are known and not read: mrad, arcmin, arcsec, dm, feet.
std::string unit_word(std::string_view word);

/// Whether a column by that name (as truepose calls it) holds words and not numbers.
bool holds_words(std::string_view name);

/// Whether a header names what a row is about, by which two files are joined: "point", "Nr", "Object Name".
bool is_key_name(std::string_view header);

/// Whether a row of that name is computed from others: "Mean", "Summe".
bool names_a_sum(std::string_view field);

/// Whether a header says of its column which rows are valid: "Valid", "is_valid", "gültig".
bool names_validity(std::string_view header);
/// Whether a field of such a column says that its row is not: "0", "false", "nein".
bool says_invalid(std::string_view field);

/// Whether a header that is not known may be of a joint: "shoulder_pan_joint", "/joint_states/position.0".
bool may_be_joint(std::string_view header);

/// Whether a header that is not known may be of the coordinate 'x', 'y' or 'z' of a reading: "X_ist", "X.1",
/// but not "X nominal" or "X std".
bool may_be_coordinate(std::string_view header, char axis);

/// Whether a header says that its column is the tracker's: "X measured".
bool names_the_tracker(std::string_view header);

/// All names of columns that some file of truepose has, those with a number ("q1") by their first.
const std::vector<std::string>& own_column_names();

/// Whether it is one of them, any number included.
bool is_own_column_name(std::string_view name);

}  // namespace truepose::config
