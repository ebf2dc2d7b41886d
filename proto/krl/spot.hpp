#pragma once

#include <cstddef>

namespace truepose::krl {

/// A place in the texts of a program.
struct Spot {
  std::size_t file = 0;  ///< of ProgramText::files
  std::size_t at = 0;    ///< byte offset
};

}  // namespace truepose::krl
