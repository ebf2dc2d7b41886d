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

std::string wrapped(std::string_view text, std::size_t width, std::size_t indent) {
  std::string out;
  std::size_t column = indent;
  while (!text.empty()) {
    const std::size_t size = std::min(text.find(' '), text.size());
    const std::string_view word = text.substr(0, size);
    text.remove_prefix(std::min(size + 1, text.size()));
    const bool breaks = !out.empty() && width > 0 && column + 1 + word.size() > width;
    if (breaks) {
      (out += '\n').append(indent, ' ');
      column = indent;
    } else if (!out.empty()) {
      out += ' ';
      ++column;
    }
    out += word;
    column += word.size();
  }
  return out;
}

std::string shown(const std::string& text) { return text.empty() ? "-" : text; }

std::string shown(std::optional<double> number, int decimals, const char* unit) {
  return number ? formatted("%.*f%s", decimals, *number, unit) : "-";
}

}  // namespace truepose::tools
