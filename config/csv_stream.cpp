#include "config/csv_stream.hpp"

#include <algorithm>

namespace truepose::config {

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
  header_.expect_width_of(row_, index());
  return true;
}

/// Takes as many lines as belong together: the next one, and more as long as a quote is open.
bool CsvStream::read_lines() {
  const bool is_first = lines_.empty();
  lines_.clear();
  std::string line;
  bool is_open = false;
  while ((lines_.empty() || is_open) && std::getline(in_, line)) {
    if (std::ranges::count(line, '"') % 2 != 0) is_open = !is_open;
    lines_ += line;
    if (!in_.eof()) lines_ += '\n';
  }
  if (in_.bad()) throw ConfigError(file_ + ": cannot be read");
  if (is_first && lines_.starts_with("\xEF\xBB\xBF")) lines_.erase(0, 3);
  return !lines_.empty();
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
