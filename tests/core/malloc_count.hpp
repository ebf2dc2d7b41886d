#pragma once

#include <cstddef>
#include <optional>

namespace truepose {

/// Calls of malloc in this program so far, those of operator new and of Eigen's matrices included; nothing
/// where a sanitizer has taken malloc for itself. A test program that uses it links malloc_count.cpp.
std::optional<std::size_t> malloc_count();

}  // namespace truepose
