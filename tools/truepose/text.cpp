#include "tools/truepose/text.hpp"

#include <algorithm>

#include "core/formatted.hpp"

namespace truepose::tools {

std::string text_table(const std::vector<Column>& columns, const std::vector<Cells>& rows) {
  std::string out;
  for (const Cells& row : rows) {
    std::string line;
    for (std::size_t i = 0; i < row.size(); ++i) {
      const auto [width, gap] = columns[i];
      const auto least = static_cast<std::size_t>(std::abs(width));
      const std::string filling(least - std::min(least, row[i].size()), ' ');
      line.append(static_cast<std::size_t>(gap), ' ');
      line += width < 0 ? row[i] + filling : filling + row[i];
    }
    out += line.substr(0, line.find_last_not_of(' ') + 1) + '\n';
  }
  return out;
}

std::string text_table(const std::vector<Cells>& rows) {
  std::vector<Column> columns;
  for (const Cells& row : rows) {
    while (columns.size() < row.size()) columns.push_back({.width = 0, .gap = columns.empty() ? 0 : 2});
    for (std::size_t i = 0; i < row.size(); ++i)
      columns[i].width = std::min(columns[i].width, -static_cast<int>(row[i].size()));
  }
  return text_table(columns, rows);
}

std::string shown(const std::string& text) { return text.empty() ? "-" : text; }

std::string shown(std::optional<double> number, int decimals, const char* unit) {
  return number ? formatted("%.*f%s", decimals, *number, unit) : "-";
}

}  // namespace truepose::tools
