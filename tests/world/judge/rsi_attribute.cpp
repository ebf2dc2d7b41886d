#include "tests/world/judge/rsi_attribute.hpp"

#include <cstdlib>

namespace truepose::world {

std::optional<double> rsi_attribute(std::string_view text, const std::string& element,
                                    const std::string& name) {
  const std::size_t begin = text.find('<' + element + ' ');
  if (begin == std::string_view::npos) return std::nullopt;
  const std::string_view inside = text.substr(begin, text.find('>', begin) - begin);
  const std::size_t at = inside.find(name + "=\"");
  if (at == std::string_view::npos) return std::nullopt;
  return std::strtod(inside.data() + at + name.size() + 2, nullptr);
}

}  // namespace truepose::world
