#pragma once

#include <cstdint>

namespace truepose::test {

/// What the preloaded library notes of a write that is not yet synced, before it is made: this, the bytes
/// that stood there, and those that shall.
struct UnsyncedWrite {
  std::int64_t offset = 0;         ///< of the bytes; what is cut off begins there
  std::int64_t before = 0;         ///< size of the file
  std::int64_t old_bytes = 0;      ///< that are replaced or cut off
  std::int64_t new_bytes = 0;      ///< that are written
  std::int64_t is_truncation = 0;  ///< else a write
};

/// Environment variable: the path that the files to be watched begin with. Their notes are in the same
/// folder.
inline constexpr const char* kWatchedFiles = "TRUEPOSE_POWER_CUT_FILES";
inline constexpr const char* kLogSuffix = ".unsynced";

}  // namespace truepose::test
