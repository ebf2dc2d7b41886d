#pragma once

#include <cstdint>
#include <optional>

namespace truepose::world {

/// Bytes that the daemon has of operator new and of SQLite; nothing where a sanitizer has taken the allocator
/// for itself.
std::optional<std::int64_t> daemon_heap_bytes();

}  // namespace truepose::world
