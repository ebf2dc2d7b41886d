#include "config/csv_stream.hpp"

#include <string_view>

namespace truepose::config {

namespace {

/// Whether a quoted field goes on behind `line`. A quote opens a field only as its first character, and again
/// directly behind the quote that closed it.
/// @param is_open  whether one goes on into the line
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

CsvStream::CsvStream(std::istream& in, std::string file)
    : in_(in), file_(std::move(file)), scanner_("", file_) {
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

}  // namespace truepose::config
