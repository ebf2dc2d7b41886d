#pragma once

#include <cstddef>

namespace truepose {

/// Calls of malloc, calloc and realloc of this thread so far, from whatever library; empty guards (always 0)
/// in sanitizer builds, which bring their own allocator. A test program that uses it links malloc_guard.cpp.
std::size_t mallocs();

}  // namespace truepose
