#pragma once

#include <cstddef>
#include <string_view>
#include <vector>

namespace truepose::krl {

/// Where a byte of a text stands, as an editor counts: both from 1, columns in bytes.
struct Place {
  std::size_t line = 1, column = 1;
};

/// Finds places in one text fast.
class Places {
 public:
  explicit Places(std::string_view text);
  Place of(std::size_t at) const;

 private:
  std::vector<std::size_t> line_starts_;
};

}  // namespace truepose::krl
