#include "config/csv_reader.hpp"

#include "config/text_file.hpp"

namespace truepose::config {

CsvTable CsvTable::read(const std::filesystem::path& file) {
  return parse(read_text_file(file), file.string());
}

CsvTable CsvTable::parse(std::string_view text, const std::string& file_name) {
  CsvTable table;
  CsvScanner scanner(text, file_name);
  table.header_ = CsvHeader(scanner.next(), file_name);
  while (auto row = scanner.next()) {
    table.header_.expect_width_of(*row, table.rows_.size());
    table.rows_.push_back(std::move(*row));
  }
  if (table.rows_.empty()) table.fail("no rows of data");
  return table;
}

}  // namespace truepose::config
