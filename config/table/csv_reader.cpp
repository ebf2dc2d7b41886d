#include "config/table/csv_reader.hpp"

#include <algorithm>
#include <array>

#include "config/number_text.hpp"

namespace truepose::config {
namespace {

std::string trimmed(std::string_view text) {
  const auto first = text.find_first_not_of(" \t");
  if (first == std::string_view::npos) return {};
  return std::string(text.substr(first, text.find_last_not_of(" \t") - first + 1));
}

/// Whether a quoted field continues behind `line`. A quote opens a field only as its first character, and
/// again directly behind the quote that closed it.
/// @param is_open  whether one continues into the line
bool is_open_behind(std::string_view line, bool is_open) {
  bool may_open = true;
  for (const char c : line) {
    if (c == '"' && (is_open || may_open)) {
      is_open = !is_open;
      may_open = true;
    } else {
      may_open = c == ',' || c == '\r';
    }
  }
  return is_open;
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
    if (at(separator_)) {
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

namespace {

/// What a spreadsheet would compute, or run.
bool is_formula(std::string_view text) {
  return !text.empty() && std::string_view{"=+-@\t\r"}.contains(text[0]);
}

/// By an apostrophe, as a spreadsheet has it of a text that would be a formula.
bool is_shown_as_text(std::string_view field) {
  return field.starts_with('\'') && (is_formula(field.substr(1)) || is_shown_as_text(field.substr(1)));
}

std::string shown_as_text(std::string field) {
  if (is_shown_as_text(field)) field.erase(0, 1);
  return field;
}

}  // namespace

std::string CsvScanner::plain_field() {
  const auto end =
      std::min(text_.find_first_of(std::array{separator_, '\r', '\n'}.data(), position_, 3), text_.size());
  const std::string_view field = text_.substr(position_, end - position_);
  position_ = end;
  return shown_as_text(std::string{trimmed(field)});
}

std::string CsvScanner::quoted_field() {
  const int first_line = line_;
  std::string field;
  ++position_;
  while (position_ < text_.size()) {
    const char c = text_[position_++];
    if (c == '"' && !at('"')) {
      if (position_ < text_.size() && !at(separator_) && !at('\r') && !at('\n')) {
        throw ConfigError(*file_ + ": line " + std::to_string(line_) + ": text after a closing quote");
      }
      return shown_as_text(std::move(field));
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
  for (const auto& [mark, shown] : {std::pair{"\xFF\xFE", "FF FE"}, std::pair{"\xFE\xFF", "FE FF"}}) {
    if (names_[0].starts_with(mark))
      fail(std::string("is in UTF-16 (byte order mark ") + shown + "), save it as UTF-8");
  }
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
  constexpr std::size_t kMostShown = 12;
  for (const std::string& name : names_) {
    if (std::ranges::find(known, name) != known.end()) continue;
    if (const std::string meant = suggestion(name, known); !meant.empty())
      fail("unknown column " + in_quotes(name) + meant);
    std::string all;
    for (std::size_t k = 0; k < std::min(known.size(), kMostShown); ++k)
      all += (k > 0 ? ", " : "") + known[k];
    fail("unknown column " + in_quotes(name) + ". Known here: " + all +
         (known.size() > kMostShown ? ", ..." : ""));
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

CsvTable CsvTable::read(const std::filesystem::path& file) {
  return parse(read_text_file(file, kMostBytes), file.string());
}

CsvTable CsvTable::parse(std::string_view text, const std::string& file_name, int first_line) {
  CsvTable table;
  CsvScanner scanner(text, file_name, first_line);
  table.header_ = CsvHeader(scanner.next(), file_name);
  while (auto row = scanner.next()) {
    table.header_.expect_width(row->fields.size(), {table.row_count(), row->line});
    if (table.row_count() == kMostRows)
      table.fail("more than " + std::to_string(kMostRows) + " rows of data");
    table.add(*row);
  }
  if (table.row_count() == 0) table.fail("no rows of data");
  return table;
}

void CsvTable::add(const CsvRow& row) {
  lines_.push_back(row.line);
  for (const std::string& field : row.fields) {
    fields_ += field;
    ends_.push_back(static_cast<std::uint32_t>(fields_.size()));
  }
}

std::string_view CsvTable::text(std::size_t row, std::size_t column) const {
  const std::size_t index = row * header_.size() + column;
  const std::size_t begin = index == 0 ? 0 : ends_[index - 1];
  return std::string_view(fields_).substr(begin, ends_[index] - begin);
}

CsvStream::CsvStream(std::istream& in, std::string file, int first_line, std::string taken)
    : in_(in), file_(std::move(file)), lines_(std::move(taken)), scanner_(lines_, file_, first_line) {
  header_ = CsvHeader(next_record(), file_);
}

bool CsvStream::next() {
  auto row = next_record();
  if (!row) {
    if (rows_ == 0) header_.fail("no rows of data");
    return false;
  }
  row_ = std::move(*row);
  ++rows_;
  header_.expect_width(row_.fields.size(), place());
  return true;
}

/// Takes as many lines as belong together: the next one, and more as long as a quote is open.
bool CsvStream::read_lines() {
  const bool is_first = lines_.empty();
  lines_.clear();
  bool is_open = false;
  for (std::size_t read = 0; (read == 0 || is_open) && read_line(); read = lines_.size()) {
    if (is_first && read == 0 && lines_.starts_with("\xEF\xBB\xBF")) lines_.erase(0, 3);
    is_open = is_open_behind(std::string_view{lines_}.substr(read), is_open);
  }
  if (in_.bad()) throw ConfigError(file_ + ": cannot be read");
  return !lines_.empty();
}

/// Puts the next line behind those that are there. @return false at the end
bool CsvStream::read_line() {
  const std::size_t before = lines_.size();
  for (char c = 0; c != '\n' && in_.get(c);) {
    if (lines_.size() == kMostBytesOfRow) {
      throw ConfigError(file_ + ": line " + std::to_string(scanner_.line()) + ": a row of more than " +
                        std::to_string(kMostBytesOfRow >> 20U) + " MiB");
    }
    lines_ += c;
  }
  return lines_.size() > before;
}

std::optional<CsvRow> CsvStream::next_record() {
  while (true) {
    if (auto row = scanner_.next()) return row;
    const int line = scanner_.line();
    if (!read_lines()) return std::nullopt;
    scanner_ = CsvScanner(lines_, file_, line);
  }
}

std::string csv_field(const std::string& given) {
  const std::string text = is_formula(given) || is_shown_as_text(given) ? "'" + given : given;
  if (text.find_first_of(",\"\r\n") == std::string::npos && !text.starts_with(' ') && !text.ends_with(' '))
    return text;
  std::string field = "\"";
  for (const char c : text) field += c == '"' ? "\"\"" : std::string(1, c);
  return field + '"';
}

}  // namespace truepose::config
