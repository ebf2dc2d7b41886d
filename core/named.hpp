#pragma once

#include <algorithm>
#include <array>
#include <string_view>
#include <vector>

namespace truepose {

/// A choice and its name on the command line and in documents.
template <typename Value>
struct Named {
  std::string_view name;
  Value value;
};

/// The name of a value that the table holds.
template <typename Value, std::size_t N>
constexpr std::string_view name_of(const std::array<Named<Value>, N>& table, Value value) {
  return std::ranges::find(table, value, &Named<Value>::value)->name;
}

/// The value of a name that the table holds.
template <typename Value, std::size_t N>
constexpr Value value_of(const std::array<Named<Value>, N>& table, std::string_view name) {
  return std::ranges::find(table, name, &Named<Value>::name)->value;
}

/// All names of a table, in its order.
template <typename Value, std::size_t N>
std::vector<std::string_view> names_of(const std::array<Named<Value>, N>& table) {
  std::vector<std::string_view> names;
  for (const Named<Value>& named : table) names.push_back(named.name);
  return names;
}

}  // namespace truepose
