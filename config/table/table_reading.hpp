#pragma once

#include <filesystem>
#include <functional>
#include <istream>
#include <optional>
#include <sstream>
#include <string>
#include <string_view>
#include <vector>

#include "core/arm/robot_model.hpp"

namespace truepose::config {

class CsvTable;

/// What a kind of table has in truepose's own form.
struct TableForm {
  std::vector<std::string> known;  ///< names that its columns may have
  std::vector<std::vector<std::string>>
      needed;                         ///< names without which it is none; one of the lists suffices
  const RobotModel* robot = nullptr;  ///< that the joints are of; null: all of them turn
  bool keeps_keys = false;            ///< other columns by which rows are joined stay, with kKeyPrefix

  bool knows(std::string_view name) const;
};

/// That a column of a file has one of our names: q1 for "A1 act". A number stands for the column at that
/// place, from 1, where no column is called so.
struct ColumnChoice {
  std::string name, header;
};

/// Units of the columns that do not say their own: "deg" or "rad"; "mm", "cm", "m" or "inch".
struct TableUnits {
  std::string angle = "deg", length = "mm";
};

/// How a table of another program is read.
struct TableReading {
  std::vector<ColumnChoice> columns{};
  std::optional<TableUnits> units{};
  /// Gets one sentence on how a file was read that is not in truepose's own form.
  std::function<void(const std::string&)> report{};
};

/// The text of a table in truepose's own form.
struct OwnForm {
  std::string text;
  int first_line = 1;  ///< number of its first line in the file
  std::string note;    ///< what was read how; empty: it was in that form
};

/// Rewrites a table that another program wrote: its text (encoding, separator, decimal commas, title rows,
/// comments, a units row, empty rows and columns), the names and units of its columns, KRL aggregates in
/// cells, quaternions and roll, pitch, yaw. Every row keeps its line. A file in truepose's own form comes
/// back as it is, and so does one that has our names and one fault, which the reader of that form then names.
///
/// @param file  stands in the messages
/// Throws ConfigError where a column is missing or means two things, or two readings of a number fit.
OwnForm own_form(std::string bytes, const std::string& file, const TableForm& form,
                 const TableReading& reading);

/// Reads a file in either form, or two that belong together, "joints.csv+points.csv" (joined()).
///
/// @param reading  null: in truepose's own form only
/// Throws ConfigError.
CsvTable read_table(const std::filesystem::path& file, const TableForm& form, const TableReading* reading);

/// The text of a table row by row. A file or pipe in truepose's own form is read as it comes, any other one
/// as a whole.
class OpenTable {
 public:
  /// @param in  outlives it @param reading  as for read_table()
  OpenTable(std::istream& in, const std::string& file, const TableForm& form, const TableReading* reading);

  std::istream& stream() { return is_own_ ? in_ : translated_; }
  int first_line() const { return first_line_; }
  /// The lines that were read from the stream to see what it is.
  const std::string& taken() const { return taken_; }

 private:
  std::istream& in_;
  std::istringstream translated_;
  std::string taken_;
  bool is_own_ = true;
  int first_line_ = 1;

  void translate(std::string bytes, const std::string& file, const TableForm& form,
                 const TableReading& reading);
};

}  // namespace truepose::config
