#include "proto/recording/shown.hpp"

#include <algorithm>

#include "core/formatted.hpp"

namespace truepose::recording {

std::string shown(std::string_view bytes) {
  const auto printable = [](char c) { return (c >= ' ' && c <= '~') || c == '\t' || c == '\n' || c == '\r'; };
  std::string line;
  if (std::ranges::all_of(bytes, printable)) {
    for (const char c : bytes) line += c < ' ' ? ' ' : c;
  } else {
    for (const char c : bytes) line += formatted("%02x", static_cast<unsigned char>(c));
  }
  return line;
}

}  // namespace truepose::recording
