#include "tools/truepose/text.hpp"

#include <unistd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <ctime>
#include <sstream>

#include "core/formatted.hpp"
#include "tools/truepose/terminal.hpp"

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

namespace {

/// Takes from the widest columns what is too much.
void narrow(std::vector<std::size_t>& widths, std::size_t width) {
  constexpr std::size_t kLeast = 12;
  std::size_t total = 2 * (widths.size() - 1);
  for (const std::size_t one : widths) total += one;
  for (; total > width; --total) {
    std::size_t& widest = *std::ranges::max_element(widths);
    if (widest <= kLeast) return;
    --widest;
  }
}

/// The lines of a row in which no cell is wider than its column, but for a word that is.
std::vector<Cells> lines_of(const Cells& row, const std::vector<std::size_t>& widths) {
  std::vector<Cells> lines(1, Cells(row.size()));
  for (std::size_t i = 0; i < row.size(); ++i) {
    std::istringstream cell{row[i].size() > widths[i] ? wrapped(row[i], widths[i], 0) : row[i]};
    std::size_t n = 0;
    for (std::string line; std::getline(cell, line); ++n) {
      if (n == lines.size()) lines.emplace_back(row.size());
      lines[n][i] = line;
    }
  }
  return lines;
}

}  // namespace

std::string text_table(const std::vector<Cells>& rows, std::size_t width) {
  std::vector<std::size_t> widths;
  for (const Cells& row : rows) {
    widths.resize(std::max(widths.size(), row.size()));
    for (std::size_t i = 0; i < row.size(); ++i) widths[i] = std::max(widths[i], row[i].size());
  }
  if (width > 0 && !widths.empty()) narrow(widths, width);
  std::vector<Column> columns;
  for (const std::size_t one : widths)
    columns.push_back({.width = -static_cast<int>(one), .gap = columns.empty() ? 0 : 2});
  std::vector<Cells> lines;
  for (const Cells& row : rows)
    for (Cells& line : lines_of(row, widths)) lines.push_back(std::move(line));
  return text_table(columns, lines);
}

std::string text_table(const std::vector<Cells>& rows) {
  return text_table(rows, is_terminal(STDOUT_FILENO) ? columns_of(STDOUT_FILENO) : 0);
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

std::string duration_text(double seconds) {
  const auto whole = static_cast<long long>(std::ceil(std::clamp(seconds, 0.0, 1e9)));
  if (whole >= 3600) return std::to_string(whole / 3600) + " h " + std::to_string(whole / 60 % 60) + " min";
  if (whole >= 60) return std::to_string(whole / 60) + " min " + std::to_string(whole % 60) + " s";
  return std::to_string(whole) + " s";
}

std::string shown_time(const std::string& utc) {
  std::tm time{};
  const char* const end = is_for_people() ? ::strptime(utc.c_str(), "%Y-%m-%dT%H:%M:%S", &time) : nullptr;
  if (end == nullptr || !utc.ends_with('Z')) return shown(utc);
  const std::time_t seconds = ::timegm(&time);
  std::array<char, 32> text{};
  std::strftime(text.data(), text.size(), "%F %T", ::localtime_r(&seconds, &time));
  return text.data();
}

std::vector<std::string> shown_ids(std::vector<std::string> ids) {
  constexpr std::size_t kFewest = 8;
  if (!is_for_people()) return ids;
  const std::vector<std::string> whole = ids;
  const auto is_unique = [&](const std::string& id, std::size_t size) {
    return std::ranges::all_of(whole, [&](const std::string& other) {
      return other == id || !other.starts_with(id.substr(0, size));
    });
  };
  for (std::string& id : ids) {
    std::size_t size = std::min(kFewest, id.size());
    while (size < id.size() && !is_unique(id, size)) ++size;
    id.resize(size);
  }
  return ids;
}

std::string shown_verdict(const std::string& name) {
  if (!shows_colors(STDOUT_FILENO)) return name;
  const bool is_good = name == "green" || name == "ok", is_bad = name == "red" || name == "failed";
  return (is_good ? "\x1b[32m" : is_bad ? "\x1b[31m" : "\x1b[33m") + name + "\x1b[0m";
}

std::string with_shown_verdict(std::string report) {
  constexpr std::string_view kStart = "\nVerdict: ";
  const std::size_t line = report.find(kStart);
  if (line == std::string::npos) return report;
  const std::size_t name = line + kStart.size();
  const std::size_t size = report.find('.', name) - name;
  return report.replace(name, size, shown_verdict(report.substr(name, size)));
}

}  // namespace truepose::tools
