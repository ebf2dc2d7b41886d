#include "tests/core/malloc_count.hpp"

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)

std::optional<std::size_t> truepose::malloc_count() { return std::nullopt; }

#else

#include <atomic>

namespace {
std::atomic<std::size_t> count{0};
}

std::optional<std::size_t> truepose::malloc_count() { return count; }

// Eigen allocates by malloc, which replacing operator new would not see.
extern "C" void* __libc_malloc(std::size_t size);
extern "C" void* malloc(std::size_t size) {
  ++count;
  return __libc_malloc(size);
}

#endif
