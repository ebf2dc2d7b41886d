#pragma once

#include <boost/json/fwd.hpp>
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

// ---- What stands in a JSON document. It may be of an older or a newer daemon: what is missing is no error
// ----

/// @param pointer  "/robot/model"
/// @return null where there is none, or null there
const boost::json::value* find_at(const boost::json::value& value, std::string_view pointer);
/// For people: "-" for what is missing, "yes" and "no".
std::string text_at(const boost::json::value& value, std::string_view pointer);
/// With so many decimals; "-" for what is no number.
std::string number_at(const boost::json::value& value, std::string_view pointer, int decimals,
                      const char* unit = "");
/// As it is; empty where there is none.
std::string string_at(const boost::json::value& value, std::string_view pointer);
bool is_true_at(const boost::json::value& value, std::string_view pointer);
const boost::json::array& list_at(const boost::json::value& value, std::string_view pointer);

}  // namespace truepose::tools
