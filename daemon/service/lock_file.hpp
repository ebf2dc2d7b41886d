#pragma once

#include <expected>
#include <filesystem>
#include <string>

#include "drivers/start_failure.hpp"

namespace truepose::daemon {

/// Keeps what belongs to one daemon from a second one. The kernel lets go of it when the process ends,
/// however it ends; the file itself stays.
class LockFile {
 public:
  /// @param of  what is kept, for the sentence "OF is in use by trueposed (process 1234)"
  static std::expected<LockFile, drivers::StartFailure> take(const std::filesystem::path& file,
                                                             const std::string& of);
  LockFile(LockFile&& other) noexcept;
  LockFile& operator=(LockFile&&) = delete;
  ~LockFile();

 private:
  explicit LockFile(int descriptor) : descriptor_{descriptor} {}
  int descriptor_;
};

/// Beside the store, not the store itself: SQLite loses its own locks when its file is closed somewhere else
/// in the process.
std::filesystem::path lock_of_store(const std::filesystem::path& store);

}  // namespace truepose::daemon
