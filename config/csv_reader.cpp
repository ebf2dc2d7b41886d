#include "config/csv_reader.hpp"

#include <algorithm>
#include <optional>

#include "config/number_text.hpp"
#include "config/suggestion.hpp"
#include "config/text_file.hpp"

namespace truepose::config {

namespace {

std::string trimmed(std::string_view text) {
  const auto first = text.find_first_not_of(" \t");
  if (first == std::string_view::npos) return {};
  return std::string(text.substr(first, text.find_last_not_of(" \t") - first + 1));
}

}  // namespace

/// Cuts the text into records.
class CsvTable::Scanner {
 public:
  Scanner(std::string_view text, const std::string& file) : text_(text), file_(file) {}

  /// The next record that is not a blank line, or nothing at the end.
  std::optional<Row> next() {
    while (position_ < text_.size()) {
      Row row = record();
      if (row.fields.size() > 1 || !row.fields[0].empty()) return row;
    }
    return std::nullopt;
  }

 private:
  Row record() {
    Row row{.fields = {}, .line = line_};
    while (true) {
      row.fields.push_back(at('"') ? quoted_field() : plain_field());
      if (at(',')) {
        ++position_;
        continue;
      }
      if (at('\r')) ++position_;
      if (at('\n')) ++position_;
      ++line_;
      return row;
    }
  }

  std::string plain_field() {
    const auto end = std::min(text_.find_first_of(",\r\n", position_), text_.size());
    const std::string_view field = text_.substr(position_, end - position_);
    position_ = end;
    return trimmed(field);
  }

  std::string quoted_field() {
    const int first_line = line_;
    std::string field;
    ++position_;
    while (position_ < text_.size()) {
      const char c = text_[position_++];
      if (c == '"' && !at('"')) {
        if (position_ < text_.size() && !at(',') && !at('\r') && !at('\n')) {
          throw ConfigError(file_ + ": line " + std::to_string(line_) + ": text after a closing quote");
        }
        return field;
      }
      if (c == '"') ++position_;
      if (c == '\n') ++line_;
      field += c;
    }
    throw ConfigError(file_ + ": line " + std::to_string(first_line) + ": a quote is not closed");
  }

  bool at(char c) const { return position_ < text_.size() && text_[position_] == c; }

  std::string_view text_;
  const std::string& file_;
  std::size_t position_ = 0;
  int line_ = 1;
};

CsvTable CsvTable::read(const std::filesystem::path& file) {
  return parse(read_text_file(file), file.string());
}

CsvTable CsvTable::parse(std::string_view text, const std::string& file_name) {
  CsvTable table;
  table.file_ = file_name;
  Scanner scanner(text, table.file_);
  const auto header = scanner.next();
  if (!header) table.fail("the file is empty, expected a header row");
  table.header_ = header->fields;
  if (table.header_.size() == 1 && table.header_[0].find_first_of(";\t") != std::string::npos) {
    table.fail("columns must be separated by commas");
  }
  for (auto name = table.header_.begin(); name != table.header_.end(); ++name) {
    if (std::find(table.header_.begin(), name, *name) != name)
      table.fail("duplicate column " + in_quotes(*name));
  }

  while (auto row = scanner.next()) {
    table.rows_.push_back(std::move(*row));
    const std::vector<std::string>& fields = table.rows_.back().fields;
    const std::size_t index = table.rows_.size() - 1;
    if (fields.size() < table.header_.size())
      table.fail(index, fields.size(), "missing, the row ends before it");
    if (fields.size() > table.header_.size()) {
      table.fail(index, table.header_.size() - 1,
                 std::to_string(fields.size()) + " fields in a row of " +
                     std::to_string(table.header_.size()) + " columns");
    }
  }
  if (table.rows_.empty()) table.fail("no rows of data");
  return table;
}

void CsvTable::expect_only(const std::vector<std::string>& known) const {
  for (const std::string& name : header_) {
    if (std::ranges::find(known, name) == known.end()) {
      fail("unknown column " + in_quotes(name) + suggestion(name, known));
    }
  }
}

bool CsvTable::has(std::string_view column) const {
  return std::ranges::find(header_, column) != header_.end();
}

std::size_t CsvTable::column(std::string_view name) const {
  const auto found = std::ranges::find(header_, name);
  if (found == header_.end()) fail("missing column " + in_quotes(name));
  return static_cast<std::size_t>(found - header_.begin());
}

double CsvTable::number(std::size_t row, std::size_t column) const {
  const std::string& field = text(row, column);
  if (field.empty()) fail(row, column, "missing, expected a number");
  const auto value = parse_number(field);
  if (!value) fail(row, column, value.error());
  return *value;
}

void CsvTable::fail(std::size_t row, std::size_t column, std::string_view what) const {
  throw ConfigError(file_ + ": row " + std::to_string(row + 1) + " (line " + std::to_string(rows_[row].line) +
                    "): " + header_[column] + ": " + std::string(what));
}

void CsvTable::fail(std::string_view what) const { throw ConfigError(file_ + ": " + std::string(what)); }

}  // namespace truepose::config
