#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "config/table/csv_reader.hpp"

namespace truepose::config {

/// Records of a text that another program wrote, and what stands between their fields.
struct TableRecords {
  std::vector<CsvRow> rows;  ///< with the comments, without blank lines
  std::string separator;     ///< "semicolons", "tabs", "blanks"; empty: commas
};

/// Cuts a text into records. Of semicolons, tabs, commas and blanks the separator is the one by which most
/// fields are numbers. Commas within the braces of a KRL aggregate separate nothing; they come back as
/// kKrlBlank, like its blanks.
///
/// Throws ConfigError as CsvScanner, and for more than CsvTable::kMostRows.
TableRecords table_records(std::string text, const std::string& file);

inline constexpr char kKrlBlank = '\x1F';

/// Whether a record is a comment: it begins with #, % or //.
bool is_comment(const CsvRow& row);

/// A number without the unit behind it, and that unit: "12.5", "mm" of "12.5 mm".
std::pair<std::string, std::string> without_unit(const std::string& field);

/// How a number is written by a program that need not write it as C does.
struct NumberMarks {
  int points = 0, commas = 0;
  bool has_groups = false;    ///< thousands set apart, by blanks, apostrophes or marks of two kinds
  bool may_be_group = false;  ///< one mark with three digits behind it, which may set thousands apart
};

/// Nothing for what is no number.
std::optional<NumberMarks> number_marks(std::string_view field);

}  // namespace truepose::config
