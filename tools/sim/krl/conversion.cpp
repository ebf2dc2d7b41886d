#include "tools/sim/krl/conversion.hpp"

#include <algorithm>

namespace truepose::sim::krl {
namespace {

int read_number(const std::string& format, std::size_t& at) {
  int number = 0;
  for (; at < format.size() && format[at] >= '0' && format[at] <= '9'; ++at)
    number = std::min(Conversion::kWidest, number * 10 + (format[at] - '0'));
  return number;
}

}  // namespace

Conversion read_conversion(const std::string& format, std::size_t& at) {
  Conversion conversion{.width = read_number(format, at)};
  if (at < format.size() && format[at] == '.') conversion.digits = read_number(format, ++at);
  if (at < format.size()) conversion.letter = format[at++];
  return conversion;
}

}  // namespace truepose::sim::krl
