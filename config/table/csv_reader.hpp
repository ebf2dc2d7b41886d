#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <istream>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "config/text_file.hpp"

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
  CsvScanner(std::string_view text, const std::string& file, int first_line = 1, char separator = ',')
      : text_(text), file_(&file), line_(first_line), separator_(separator) {}

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
  char separator_;
};

/// The header row of a CSV file: what its columns are called, and how an error says where it is.
class CsvHeader {
 public:
  CsvHeader() = default;
  /// Throws ConfigError where there is none, or a name is there twice.
  CsvHeader(const std::optional<CsvRow>& row, std::string file);

  std::size_t size() const { return names_.size(); }
  const std::vector<std::string>& names() const { return names_; }
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

/// A text as it is written: in quotes where it needs them, and with an apostrophe in front where a
/// spreadsheet would take it for a formula, which the reader takes away.
std::string csv_field(const std::string& text);

/// A CSV file with a header row (RFC 4180: quoted fields, LF or CRLF; a byte order mark is skipped). Every
/// error is a ConfigError "file: row 7 (line 8): column: what", where row 1 is the first row of data. Blank
/// lines are no rows. It takes time and memory in proportion to the file, which has bounds.
class CsvTable {
 public:
  static constexpr std::size_t kMostBytes = std::size_t{64} << 20;
  static constexpr std::size_t kMostRows = 1'000'000;

  static CsvTable read(const std::filesystem::path& file);
  /// @param first_line  number of the text's first line in the file
  static CsvTable parse(std::string_view text, const std::string& file_name, int first_line = 1);

  /// Refuses columns that are not in `known`.
  void expect_only(const std::vector<std::string>& known) const { header_.expect_only(known); }
  bool has(std::string_view column) const { return header_.has(column); }
  /// Index of a column that must be there.
  std::size_t column(std::string_view name) const { return header_.column(name); }

  const std::vector<std::string>& columns() const { return header_.names(); }

  std::size_t row_count() const { return lines_.size(); }
  /// Where a row begins in the file.
  int line(std::size_t row) const { return lines_[row]; }
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

/// A CSV file read row by row, for files and pipes of any length; otherwise as CsvTable.
class CsvStream {
 public:
  static constexpr std::size_t kMostBytesOfRow = std::size_t{1} << 20;

  /// Reads the header row. @param file  stands in the messages @param first_line  as for CsvTable::parse()
  /// @param taken  whole lines that were read from it already
  CsvStream(std::istream& in, std::string file, int first_line = 1, std::string taken = {});
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
