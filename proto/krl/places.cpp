#include "proto/krl/places.hpp"

#include <algorithm>

namespace truepose::krl {

Places::Places(std::string_view text) : line_starts_{0} {
  for (std::size_t i = text.find('\n'); i != std::string_view::npos; i = text.find('\n', i + 1)) {
    line_starts_.push_back(i + 1);
  }
}

Place Places::of(std::size_t at) const {
  const auto line =
      static_cast<std::size_t>(std::ranges::upper_bound(line_starts_, at) - line_starts_.begin());
  return {line, at - line_starts_[line - 1] + 1};
}

}  // namespace truepose::krl
