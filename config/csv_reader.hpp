#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "config/csv_scanner.hpp"

namespace truepose::config {

/// A CSV file with a header row (RFC 4180: quoted fields, LF or CRLF; a byte order mark is skipped). Every
/// error is a ConfigError "file: row 7 (line 8): column: what", where row 1 is the first row of data. Blank
/// lines are no rows. It takes time and memory in proportion to the file, which has bounds.
class CsvTable {
 public:
  static constexpr std::size_t kMostBytes = std::size_t{64} << 20;
  static constexpr std::size_t kMostRows = 1'000'000;

  static CsvTable read(const std::filesystem::path& file);
  static CsvTable parse(std::string_view text, const std::string& file_name);

  /// Refuses columns that are not in `known`.
  void expect_only(const std::vector<std::string>& known) const { header_.expect_only(known); }
  bool has(std::string_view column) const { return header_.has(column); }
  /// Index of a column that must be there.
  std::size_t column(std::string_view name) const { return header_.column(name); }

  std::size_t row_count() const { return lines_.size(); }
  /// Valid as long as the table.
  std::string_view text(std::size_t row, std::size_t column) const;
  /// A finite number that must be there.
  double number(std::size_t row, std::size_t column) const {
    return header_.number(text(row, column), place(row), column);
  }

  /// @param row  counted from 0
  [[noreturn]] void fail(std::size_t row, std::size_t column, std::string_view what) const {
    header_.fail(place(row), column, what);
  }
  /// An error of the file as a whole.
  [[noreturn]] void fail(std::string_view what) const { header_.fail(what); }

 private:
  void add(const CsvRow& row);
  CsvPlace place(std::size_t row) const { return {row, lines_[row]}; }

  CsvHeader header_;
  std::vector<int> lines_;           // of each row
  std::string fields_;               // of all rows, one behind the other
  std::vector<std::uint32_t> ends_;  // of each field in fields_
};

}  // namespace truepose::config
