#pragma once

#include <array>
#include <string>
#include <string_view>
#include <utility>
#include <variant>

#include "tools/truepose/command_line.hpp"

namespace truepose::tools {

/// Options with a letter of their own, which is the same in all commands.
inline constexpr std::array<std::pair<std::string_view, std::string_view>, 3> kShortNames{
    {{"--out", "-o"}, {"--quiet", "-q"}, {"--verbose", "-v"}}};

/// "-o"; empty: none.
constexpr std::string_view short_name(std::string_view option) {
  for (const auto& [name, letter] : kShortNames)
    if (name == option) return letter;
  return {};
}

inline bool has_dashes(const Option& option) { return option.name.starts_with("--"); }

/// Whether it can be given without its name.
inline bool goes_by_place(const Option& option) { return !has_dashes(option) || !option.rules.place.empty(); }

/// "--no-variation" of "--variation", where both are options; else empty.
inline std::string negated_name(const Option& option) {
  const bool is_two = std::holds_alternative<std::optional<bool>*>(option.target);
  return is_two ? "--no-" + option.name.substr(2) : "";
}

inline bool is_flag(const Option& option) {
  return std::holds_alternative<bool*>(option.target) ||
         std::holds_alternative<std::optional<bool>*>(option.target);
}

/// "FILE", "MM", "N": the kind of an option's value in --help; empty for a flag.
std::string kind_of(const Option& option);

/// How it is called where it goes by its place: "ROBOT".
std::string name_of_place(const Option& option);

}  // namespace truepose::tools
