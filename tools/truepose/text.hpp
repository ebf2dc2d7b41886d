#pragma once

#include <concepts>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace truepose::tools {

// ---- Tables ----

using Cells = std::vector<std::string>;

struct Column {
  int width;    ///< at least; negative where the cells begin at the left, as printf has it
  int gap = 0;  ///< spaces before it
};

/// Rows of cells, a line each without spaces at its end. A cell that is wider than its column moves what
/// follows.
std::string text_table(const std::vector<Column>& columns, const std::vector<Cells>& rows);

/// The same with columns as wide as their widest cell, from the left, two spaces apart.
std::string text_table(const std::vector<Cells>& rows);

/// Text in lines of at most `width` columns, broken between words. A longer word has a line of its own.
/// @param indent  of every line but the first, which begins at this column too; 0 of `width`: one line
std::string wrapped(std::string_view text, std::size_t width, std::size_t indent);

// ---- Values for people: "-" for what is empty ----

std::string shown(const std::string& text);
/// With so many decimals.
std::string shown(std::optional<double> number, int decimals, const char* unit = "");
template <std::integral T>
std::string shown(T x) {
  if constexpr (std::same_as<T, bool>)
    return x ? "yes" : "no";
  else
    return std::to_string(x);
}
template <class T>
std::string shown(const std::optional<T>& x) {
  return x ? shown(*x) : "-";
}

}  // namespace truepose::tools
