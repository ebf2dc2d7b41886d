#include "tests/allocations.hpp"

#include "tests/sanitized.hpp"

#if TRUEPOSE_SANITIZED

std::optional<std::size_t> truepose::allocations() { return std::nullopt; }

#else

namespace {
thread_local constinit std::size_t count = 0;
}

std::optional<std::size_t> truepose::allocations() { return count; }

// glibc's own allocator under the names that it can be reached by when malloc is replaced.
extern "C" {
void* __libc_malloc(std::size_t size);
void* __libc_calloc(std::size_t items, std::size_t size);
void* __libc_realloc(void* memory, std::size_t size);

void* malloc(std::size_t size) {
  ++count;
  return __libc_malloc(size);
}
void* calloc(std::size_t items, std::size_t size) {
  ++count;
  return __libc_calloc(items, size);
}
void* realloc(void* memory, std::size_t size) {
  ++count;
  return __libc_realloc(memory, size);
}
}

#endif
