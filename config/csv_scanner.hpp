#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "config/config_error.hpp"

namespace truepose::config {

inline constexpr std::size_t kMostCsvColumns = 1000;

struct CsvRow {
  std::vector<std::string> fields;
  int line = 0;  ///< where it begins
};

/// What an error calls a row of data.
struct CsvPlace {
  std::size_t row = 0;  ///< counted from 0
  int line = 0;         ///< where it begins
};

/// Cuts a text into records (RFC 4180: quoted fields, LF or CRLF) of at most kMostCsvColumns fields.
class CsvScanner {
 public:
  /// @param file  stands in the messages; outlives the scanner
  CsvScanner(std::string_view text, const std::string& file, int first_line = 1)
      : text_(text), file_(&file), line_(first_line) {}

  /// The next record that is not a blank line, or nothing at the end. Throws ConfigError.
  std::optional<CsvRow> next();
  int line() const { return line_; }

 private:
  CsvRow record();
  std::string plain_field();
  std::string quoted_field();
  bool at(char c) const { return position_ < text_.size() && text_[position_] == c; }

  std::string_view text_;
  const std::string* file_;
  std::size_t position_ = 0;
  int line_;
};

/// The header row of a CSV file: what its columns are called, and how an error says where it is.
class CsvHeader {
 public:
  CsvHeader() = default;
  /// Throws ConfigError where there is none, or a name is there twice.
  CsvHeader(const std::optional<CsvRow>& row, std::string file);

  std::size_t size() const { return names_.size(); }
  bool has(std::string_view column) const;
  std::size_t column(std::string_view name) const;
  void expect_only(const std::vector<std::string>& known) const;

  /// Refuses a record of more or fewer fields.
  void expect_width(std::size_t fields, CsvPlace place) const;
  double number(std::string_view field, CsvPlace place, std::size_t column) const;

  [[noreturn]] void fail(CsvPlace place, std::size_t column, std::string_view what) const;
  [[noreturn]] void fail(std::string_view what) const;

 private:
  std::string file_;
  std::vector<std::string> names_;
};

}  // namespace truepose::config
