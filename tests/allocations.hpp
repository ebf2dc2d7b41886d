#pragma once

#include <cstddef>
#include <optional>

namespace truepose {

/// Calls of malloc, calloc and realloc of this thread so far, those of operator new and of Eigen's matrices
/// included, from whatever library; nothing where a sanitizer has taken malloc for itself. A test program
/// that uses it links allocations.cpp.
std::optional<std::size_t> allocations();

}  // namespace truepose
