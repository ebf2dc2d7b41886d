#include "config/csv_scanner.hpp"

#include <algorithm>

#include "config/number_text.hpp"
#include "config/suggestion.hpp"

namespace truepose::config {

namespace {

std::string trimmed(std::string_view text) {
  const auto first = text.find_first_not_of(" \t");
  if (first == std::string_view::npos) return {};
  return std::string(text.substr(first, text.find_last_not_of(" \t") - first + 1));
}

}  // namespace

std::optional<CsvRow> CsvScanner::next() {
  while (position_ < text_.size()) {
    CsvRow row = record();
    if (row.fields.size() > 1 || !row.fields[0].empty()) return row;
  }
  return std::nullopt;
}

CsvRow CsvScanner::record() {
  CsvRow row{.fields = {}, .line = line_};
  while (true) {
    row.fields.push_back(at('"') ? quoted_field() : plain_field());
    if (at(',')) {
      if (row.fields.size() == kMostCsvColumns) {
        throw ConfigError(*file_ + ": line " + std::to_string(line_) + ": more than " +
                          std::to_string(kMostCsvColumns) + " columns");
      }
      ++position_;
      continue;
    }
    if (at('\r')) ++position_;
    if (at('\n')) ++position_;
    ++line_;
    return row;
  }
}

std::string CsvScanner::plain_field() {
  const auto end = std::min(text_.find_first_of(",\r\n", position_), text_.size());
  const std::string_view field = text_.substr(position_, end - position_);
  position_ = end;
  return trimmed(field);
}

std::string CsvScanner::quoted_field() {
  const int first_line = line_;
  std::string field;
  ++position_;
  while (position_ < text_.size()) {
    const char c = text_[position_++];
    if (c == '"' && !at('"')) {
      if (position_ < text_.size() && !at(',') && !at('\r') && !at('\n')) {
        throw ConfigError(*file_ + ": line " + std::to_string(line_) + ": text after a closing quote");
      }
      return field;
    }
    if (c == '"') ++position_;
    if (c == '\n') ++line_;
    field += c;
  }
  throw ConfigError(*file_ + ": line " + std::to_string(first_line) + ": a quote is not closed");
}

CsvHeader::CsvHeader(const std::optional<CsvRow>& row, std::string file) : file_(std::move(file)) {
  if (!row) fail("the file is empty, expected a header row");
  names_ = row->fields;
  if (names_.size() == 1 && names_[0].find_first_of(";\t") != std::string::npos)
    fail("columns must be separated by commas");
  for (auto name = names_.begin(); name != names_.end(); ++name) {
    if (std::find(names_.begin(), name, *name) != name) fail("duplicate column " + in_quotes(*name));
  }
}

bool CsvHeader::has(std::string_view column) const {
  return std::ranges::find(names_, column) != names_.end();
}

std::size_t CsvHeader::column(std::string_view name) const {
  const auto found = std::ranges::find(names_, name);
  if (found == names_.end()) fail("missing column " + in_quotes(name));
  return static_cast<std::size_t>(found - names_.begin());
}

void CsvHeader::expect_only(const std::vector<std::string>& known) const {
  for (const std::string& name : names_) {
    if (std::ranges::find(known, name) == known.end())
      fail("unknown column " + in_quotes(name) + suggestion(name, known));
  }
}

void CsvHeader::expect_width(std::size_t fields, CsvPlace place) const {
  if (fields < size()) fail(place, fields, "missing, the row ends before it");
  if (fields > size()) {
    fail(place, size() - 1,
         std::to_string(fields) + " fields in a row of " + std::to_string(size()) + " columns");
  }
}

double CsvHeader::number(std::string_view field, CsvPlace place, std::size_t column) const {
  if (field.empty()) fail(place, column, "missing, expected a number");
  const auto value = parse_number(field);
  if (!value) fail(place, column, value.error());
  return *value;
}

void CsvHeader::fail(CsvPlace place, std::size_t column, std::string_view what) const {
  throw ConfigError(file_ + ": row " + std::to_string(place.row + 1) + " (line " +
                    std::to_string(place.line) + "): " + names_[column] + ": " + std::string(what));
}

void CsvHeader::fail(std::string_view what) const { throw ConfigError(file_ + ": " + std::string(what)); }

}  // namespace truepose::config
