#include "daemon/store/correction_mark.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <string>
#include <system_error>

namespace truepose::daemon {
namespace {

namespace fs = std::filesystem;

fs::path mark_of(const fs::path& store) {
  fs::path mark = store;
  return mark += ".corrected";
}

/// @return 0, or an errno
int make_durable(const fs::path& path, int flags) {
  const int descriptor = ::open(path.c_str(), flags | O_CLOEXEC, 0600);
  if (descriptor < 0) return errno;
  const int failed = ::fsync(descriptor) == 0 ? 0 : errno;
  ::close(descriptor);
  return failed;
}

}  // namespace

bool may_have_corrected(const fs::path& store) noexcept {
  std::error_code failed;
  const bool there = fs::exists(mark_of(store), failed);
  return there || failed;
}

StoreResult<void> keep_corrected(const fs::path& store) {
  if (store.empty()) return {};
  std::error_code unknown;
  const fs::path mark = mark_of(store);
  if (fs::exists(mark, unknown)) return {};
  int failed = make_durable(mark, O_WRONLY | O_CREAT | O_NOFOLLOW);
  if (failed == 0)
    failed = make_durable(mark.has_parent_path() ? mark.parent_path() : ".", O_RDONLY | O_DIRECTORY);
  if (failed == 0) return {};
  const bool full = failed == ENOSPC || failed == EDQUOT;
  return std::unexpected(StoreError{mark.string() + ": cannot be written: " + std::strerror(failed), full});
}

}  // namespace truepose::daemon
