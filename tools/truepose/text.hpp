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

/// The same with columns as wide as their widest cell, from the left, two spaces apart. Where that is wider
/// than `width`, the widest columns are narrower, and their cells have several lines; 0: as wide as they are.
std::string text_table(const std::vector<Cells>& rows, std::size_t width);
/// The same, on a terminal as wide as that is.
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

/// "18 s", "2 min 5 s", "1 h 20 min", rounded up.
std::string duration_text(double seconds);

/// "2026-01-31T12:00:00.000Z" as the local time for people; in a file or a pipe, and where it is none, as it
/// is.
std::string shown_time(const std::string& utc);

/// The same ids, for people each by its first letters that no other begins with, eight or more.
std::vector<std::string> shown_ids(std::vector<std::string> ids);

/// The name of a verdict ("green", "warning", "failed"), in its colour on a terminal.
std::string shown_verdict(const std::string& name);
/// The same within a report that has a line "Verdict: green. ..".
std::string with_shown_verdict(std::string report);

}  // namespace truepose::tools
