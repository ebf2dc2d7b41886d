#pragma once

#include <cstddef>

namespace truepose {

/// Calls of the global operator new in this program so far. A test program that uses it links
/// allocation_guard.cpp.
std::size_t allocations();

}  // namespace truepose
