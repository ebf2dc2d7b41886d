#pragma once

#include <getopt.h>

#include <array>
#include <charconv>
#include <cstddef>
#include <cstdio>
#include <limits>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>

#include "config/number_text.hpp"

namespace truepose::config {

/// One line for the operator, exit code 2.
struct UsageError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

inline constexpr const char* kSeeHelp = "; --help shows the options";

/// An option of a program that has no commands, and what it does with its value, which is in optarg.
template <typename Options>
struct ProgramOption {
  const char* name;
  void (*take)(Options& options);
  int argument = required_argument;
};

/// The value of the option that was just read. Throws UsageError where it is no such number.
template <typename Number>
Number number_of(const char* option, const char* expected = "a whole number",
                 Number least = std::numeric_limits<Number>::lowest(),
                 Number most = std::numeric_limits<Number>::max()) {
  const std::string_view text{optarg};
  Number number{};
  const auto [end, fault] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (fault != std::errc{} || end != text.data() + text.size() || !(number >= least && number <= most))
    throw UsageError{std::string{option} + ": expected " + expected + ", found " + in_quotes(text) +
                     kSeeHelp};
  return number;
}

/// @return none where help was asked for, and is printed. Throws UsageError
template <typename Options, std::size_t count>
std::optional<Options> read_options(int argc, char** argv,
                                    const std::array<ProgramOption<Options>, count>& known,
                                    const char* help) {
  std::array<option, count + 2> names{};  // the last one ends the list
  for (std::size_t i = 0; i < count; ++i)
    names[i] = {known[i].name, known[i].argument, nullptr, static_cast<int>(i)};
  names[count] = {"help", no_argument, nullptr, 'h'};
  Options options;
  opterr = 0;
  for (int found; (found = getopt_long(argc, argv, ":h", names.data(), nullptr)) != -1;) {
    if (found == 'h') {
      std::fputs(help, stdout);
      return std::nullopt;
    }
    const std::string word = argv[optind - 1];
    if (found == ':') throw UsageError{word + " needs a value" + kSeeHelp};
    if (found == '?') throw UsageError{word + " is no option" + kSeeHelp};
    known[static_cast<std::size_t>(found)].take(options);
  }
  if (optind < argc) throw UsageError{std::string{argv[optind]} + " belongs to no option" + kSeeHelp};
  return options;
}

}  // namespace truepose::config
