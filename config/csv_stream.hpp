#pragma once

#include <istream>
#include <string>

#include "config/csv_scanner.hpp"

namespace truepose::config {

/// A CSV file read row by row, for files and pipes of any length; otherwise as CsvTable.
class CsvStream {
 public:
  static constexpr std::size_t kMostBytesOfRow = std::size_t{1} << 20;

  /// Reads the header row. @param file  stands in the messages
  CsvStream(std::istream& in, std::string file);
  CsvStream(const CsvStream&) = delete;
  CsvStream& operator=(const CsvStream&) = delete;

  const CsvHeader& header() const { return header_; }

  /// Goes to the next row. @return false at the end. Throws ConfigError, also where no row came at all.
  bool next();
  /// Of the row: how many came before it.
  std::size_t index() const { return rows_ - 1; }
  double number(std::size_t column) const { return header_.number(row_.fields[column], place(), column); }
  [[noreturn]] void fail(std::size_t column, std::string_view what) const {
    header_.fail(place(), column, what);
  }

 private:
  CsvPlace place() const { return {index(), row_.line}; }
  bool read_lines();
  bool read_line();
  std::optional<CsvRow> next_record();

  std::istream& in_;
  std::string file_;
  std::string lines_;
  CsvScanner scanner_;
  CsvHeader header_;
  CsvRow row_;
  std::size_t rows_ = 0;
};

}  // namespace truepose::config
