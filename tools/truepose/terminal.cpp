#include "tools/truepose/terminal.hpp"

#include <sys/ioctl.h>
#include <unistd.h>

#include <charconv>
#include <cstdlib>
#include <string_view>

namespace truepose::tools {
namespace {

std::string_view environment(const char* name) {
  const char* const value = std::getenv(name);
  return value == nullptr ? "" : value;
}

}  // namespace

std::size_t columns_of(int descriptor) {
  constexpr std::size_t kFewest = 20;  // below, words alone are wider
  std::size_t columns = 0;
  const std::string_view given = environment("COLUMNS");
  std::from_chars(given.data(), given.data() + given.size(), columns);
  if (winsize size{}; columns == 0 && ::ioctl(descriptor, TIOCGWINSZ, &size) == 0) columns = size.ws_col;
  return columns < kFewest ? 0 : columns;
}

bool is_terminal(int descriptor) { return ::isatty(descriptor) == 1; }

Manner& manner() {
  static Manner manner;
  return manner;
}

bool is_for_people() { return is_terminal(STDOUT_FILENO) && !manner().verbose; }

bool shows_colors(int descriptor) {
  return is_terminal(descriptor) && environment("NO_COLOR").empty() && environment("TERM") != "dumb";
}

}  // namespace truepose::tools
