#include "tests/world/heap_count.hpp"

#include <sqlite3.h>

#include <atomic>
#include <cstddef>
#include <cstdlib>
#include <new>

#include "tests/daemon_heap.hpp"
#include "tests/sanitized.hpp"

namespace {

constinit std::atomic<std::int64_t> bytes_of_daemon = 0;

}  // namespace

namespace truepose::world {

std::optional<std::int64_t> daemon_heap_bytes() {
#if TRUEPOSE_SANITIZED
  return std::nullopt;
#else
  return bytes_of_daemon + sqlite3_memory_used();
#endif
}

}  // namespace truepose::world

#if !TRUEPOSE_SANITIZED

namespace {

/// Stands before each block, from which operator delete knows whose it was.
struct alignas(std::max_align_t) Header {
  std::int64_t bytes_of_daemon;
};

}  // namespace

void* operator new(std::size_t size) {
  void* const memory = std::malloc(sizeof(Header) + size);
  if (memory == nullptr) throw std::bad_alloc{};
  auto* const header =
      new (memory) Header{truepose::allocates_for_daemon ? static_cast<std::int64_t>(size) : 0};
  if (truepose::allocates_for_daemon) bytes_of_daemon += header->bytes_of_daemon;
  return header + 1;
}

void operator delete(void* block) noexcept {
  if (block == nullptr) return;
  Header* const header = static_cast<Header*>(block) - 1;
  if (header->bytes_of_daemon > 0) bytes_of_daemon -= header->bytes_of_daemon;
  std::free(header);
}

void operator delete(void* block, std::size_t) noexcept { ::operator delete(block); }

#endif
