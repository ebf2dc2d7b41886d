#pragma once

#include <sys/stat.h>

#include <array>
#include <cstdint>
#include <filesystem>

namespace truepose::daemon {

/// By which a file is known to be another than when it was looked at last. Zeros: not there.
using FileStamp = std::array<std::int64_t, 5>;

inline FileStamp stamp_of(const std::filesystem::path& file) {
  struct stat found {};
  if (::stat(file.c_str(), &found) != 0) return {};
  return {static_cast<std::int64_t>(found.st_ino), found.st_mtim.tv_sec, found.st_mtim.tv_nsec,
          found.st_ctim.tv_sec, found.st_ctim.tv_nsec};
}

}  // namespace truepose::daemon
