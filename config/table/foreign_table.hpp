#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "config/table/column_name.hpp"
#include "config/table/csv_reader.hpp"

namespace truepose::config {

/// A table as another program wrote it: a header, and rows of as many fields.
struct ForeignTable {
  std::string file;                  ///< in messages
  std::vector<std::string> headers;  ///< as the file has them
  std::vector<ColumnName> columns;   ///< what they mean; without a name: left out
  std::vector<CsvRow> rows;          ///< of data

  /// Throws ConfigError: "data.csv: row 7 (line 9): X [mm]: what".
  [[noreturn]] void fail(std::size_t row, std::size_t column, std::string_view what) const;
  [[noreturn]] void fail(std::string_view what) const;

  /// Place of the column of that meaning, or how many there are.
  std::size_t find(std::string_view name) const;
  /// A column behind all others.
  void add(std::string header, ColumnName meaning, const std::vector<std::string>& fields);
};

/// Leaves out rows that a column says are not valid. Throws ConfigError where none is left.
/// @return what was left out; empty: nothing
std::string leave_out_invalid_rows(ForeignTable& table);

/// Columns of KRL aggregates, {E6AXIS: A1 1.0, A2 ..}, as columns of their members; the columns themselves
/// are left out. Throws ConfigError where a row has other members.
void expand_krl_columns(ForeignTable& table);

/// Quaternions (qw, qx, qy, qz) and angles about the fixed x, y, z in this order (roll, pitch, yaw; FANUC's
/// w, p, r) as columns a, b, c of KUKA's angles in deg, where there are none. @return what was converted;
/// empty: nothing Throws ConfigError where a number is missing, a quaternion is not of length 1, angles may
/// be deg and rad, and for rx, ry, rz, which have two meanings.
std::string convert_orientations(ForeignTable& table, std::string_view angle_unit);

/// Numbers with points and without units: "12,5 mm" as "12.5". Throws ConfigError where two readings fit.
/// @return whether there were decimal commas
bool normalise_numbers(ForeignTable& table);

}  // namespace truepose::config
