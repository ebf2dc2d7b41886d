#pragma once

#include <algorithm>
#include <cstdio>
#include <functional>
#include <random>
#include <string>
#include <string_view>
#include <vector>

#include "core/formatted.hpp"

namespace truepose::config {

using Names = std::vector<std::string>;

inline Names plus(Names names, const Names& more) {
  names.insert(names.end(), more.begin(), more.end());
  return names;
}

/// A sheet of measurements as text, from which the files of a corpus are made: joints of six axes in deg and
/// points in mm, the numbers of one correct file.
struct Sheet {
  std::vector<std::string> header;
  std::vector<std::vector<std::string>> rows;

  static Sheet correct(std::size_t count = 12) {
    Sheet sheet{{"q1", "q2", "q3", "q4", "q5", "q6", "x", "y", "z"}, {}};
    std::minstd_rand random{7};
    const auto between = [&](double low, double high) {
      return low + (high - low) * static_cast<double>(random() % 1'000'000) / 1e6;
    };
    for (std::size_t k = 0; k < count; ++k) {
      auto& row = sheet.rows.emplace_back();
      for (int joint = 0; joint < 6; ++joint) row.push_back(formatted("%.4f", between(-130, 130)));
      for (int axis = 0; axis < 3; ++axis) row.push_back(formatted("%.4f", between(200, 3600)));
    }
    return sheet;
  }

  Sheet with_header(std::vector<std::string> names) const { return {std::move(names), rows}; }
  /// A further column, in front of the one at that place.
  Sheet with_column(std::size_t place, const std::string& name,
                    const std::function<std::string(std::size_t row)>& field) const {
    Sheet sheet = *this;
    const auto at = static_cast<std::ptrdiff_t>(place);
    sheet.header.insert(sheet.header.begin() + at, name);
    for (std::size_t k = 0; k < rows.size(); ++k) sheet.rows[k].insert(sheet.rows[k].begin() + at, field(k));
    return sheet;
  }
  Sheet with_column(std::size_t place, const std::string& name, const std::string& field) const {
    return with_column(place, name, [&](std::size_t) { return field; });
  }
  Sheet with_field(std::size_t row, std::size_t column, const std::string& field) const {
    Sheet sheet = *this;
    sheet.rows[row][column] = field;
    return sheet;
  }
  /// Columns multiplied, with more digits than the file's own.
  Sheet scaled(std::size_t first, std::size_t end, double factor) const {
    Sheet sheet = *this;
    for (auto& row : sheet.rows)
      for (std::size_t k = first; k < end; ++k) row[k] = formatted("%.12f", std::stod(row[k]) * factor);
    return sheet;
  }
  Sheet each_field(const std::function<std::string(std::string)>& change) const {
    Sheet sheet = *this;
    for (auto& row : sheet.rows)
      for (std::string& field : row) field = change(field);
    return sheet;
  }
  Sheet with_decimal_commas() const {
    return each_field([](std::string field) {
      std::ranges::replace(field, '.', ',');
      return field;
    });
  }

  std::string text(const std::string& separator = ",", const std::string& line_end = "\n") const {
    std::string text = line(header, separator) + line_end;
    return text += rows_text(separator, line_end);
  }
  std::string rows_text(const std::string& separator = ",", const std::string& line_end = "\n") const {
    std::string text;
    for (const auto& row : rows) text += line(row, separator) + line_end;
    return text;
  }

  static std::string line(const std::vector<std::string>& fields, const std::string& separator) {
    std::string line;
    for (const std::string& field : fields) line += (&field == &fields.front() ? "" : separator) + field;
    return line;
  }
};

/// ASCII text in UTF-16.
inline std::string utf16(std::string_view text, bool is_little, bool has_mark) {
  std::string bytes;
  if (has_mark) bytes = is_little ? "\xFF\xFE" : "\xFE\xFF";
  for (const char c : text) {
    if (!is_little) bytes += '\0';
    bytes += c;
    if (is_little) bytes += '\0';
  }
  return bytes;
}

}  // namespace truepose::config
