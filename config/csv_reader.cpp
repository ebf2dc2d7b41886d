#include "config/csv_reader.hpp"

#include "config/text_file.hpp"

namespace truepose::config {

CsvTable CsvTable::read(const std::filesystem::path& file) {
  return parse(read_text_file(file, kMostBytes), file.string());
}

CsvTable CsvTable::parse(std::string_view text, const std::string& file_name) {
  CsvTable table;
  CsvScanner scanner(text, file_name);
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

}  // namespace truepose::config
