#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "config/csv_scanner.hpp"

namespace truepose::config {

/// A CSV file with a header row (RFC 4180: quoted fields, LF or CRLF; a byte order mark is skipped). Every
/// error is a ConfigError "file: row 7 (line 8): column: what", where row 1 is the first row of data. Blank
/// lines are no rows.
class CsvTable {
 public:
  static CsvTable read(const std::filesystem::path& file);
  static CsvTable parse(std::string_view text, const std::string& file_name);

  /// Refuses columns that are not in `known`.
  void expect_only(const std::vector<std::string>& known) const { header_.expect_only(known); }
  bool has(std::string_view column) const { return header_.has(column); }
  /// Index of a column that must be there.
  std::size_t column(std::string_view name) const { return header_.column(name); }

  std::size_t row_count() const { return rows_.size(); }
  const std::string& text(std::size_t row, std::size_t column) const { return rows_[row].fields[column]; }
  /// A finite number that must be there.
  double number(std::size_t row, std::size_t column) const { return header_.number(rows_[row], row, column); }

  /// @param row  counted from 0
  [[noreturn]] void fail(std::size_t row, std::size_t column, std::string_view what) const {
    header_.fail(rows_[row], row, column, what);
  }
  /// An error of the file as a whole.
  [[noreturn]] void fail(std::string_view what) const { header_.fail(what); }

 private:
  CsvHeader header_;
  std::vector<CsvRow> rows_;
};

}  // namespace truepose::config
