// Preloaded into a daemon, notes what it has written to its store and not yet synced, so that a test can take
// from the disk what a power cut may take.

#include <dlfcn.h>
#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdarg>
#include <cstdlib>
#include <cstring>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include "tests/integration/power_cut_log.hpp"

namespace {

using truepose::test::UnsyncedWrite;

template <typename Function>
Function* next(const char* name) {
  return reinterpret_cast<Function*>(::dlsym(RTLD_NEXT, name));
}
/// The C library's, found when first asked for: a sanitizer calls before any constructor runs.
struct Real {
  int (*open)(const char*, int, ...) = next<int(const char*, int, ...)>("open64");
  int (*close)(int) = next<int(int)>("close");
  ssize_t (*write)(int, const void*, size_t) = next<ssize_t(int, const void*, size_t)>("write");
  ssize_t (*pwrite)(int, const void*, size_t,
                    off64_t) = next<ssize_t(int, const void*, size_t, off64_t)>("pwrite64");
  int (*truncate)(int, off64_t) = next<int(int, off64_t)>("ftruncate64");
  int (*fsync)(int) = next<int(int)>("fsync");
  int (*fdatasync)(int) = next<int(int)>("fdatasync");
  int (*unlink)(const char*) = next<int(const char*)>("unlink");
};
const Real& real() {
  static const Real all;
  return all;
}

/// The notes of the file behind each descriptor.
constexpr int kNone = -1;
constinit std::mutex mutex;
constinit auto logs = [] {
  std::array<int, 4096> none;
  none.fill(kNone);
  return none;
}();

bool is_watched(const char* path) {
  const char* const begin = std::getenv(truepose::test::kWatchedFiles);
  const std::string suffix = truepose::test::kLogSuffix;
  const std::string text = path;
  return begin != nullptr && text.starts_with(begin) && !text.ends_with(suffix) && !text.ends_with("-shm");
}

int log_of(int file) {
  return file >= 0 && file < static_cast<int>(logs.size()) ? logs[static_cast<std::size_t>(file)] : kNone;
}

void watch(int file, const char* path) {
  if (file < 0 || file >= static_cast<int>(logs.size()) || !is_watched(path)) return;
  const std::lock_guard lock{mutex};
  const std::string log = path + std::string{truepose::test::kLogSuffix};
  logs[static_cast<std::size_t>(file)] =
      real().open(log.c_str(), O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0600);
}

off64_t size_of(int file) {
  struct stat64 found {};
  return ::fstat64(file, &found) == 0 ? found.st_size : 0;
}

/// Whoever cannot note has no power to cut.
void note(int file, int log, UnsyncedWrite write, const void* bytes) {
  write.before = size_of(file);
  const off64_t end = write.is_truncation != 0 ? write.before : write.offset + write.new_bytes;
  write.old_bytes = std::max<off64_t>(0, std::min(end, off64_t{write.before}) - write.offset);
  std::vector<char> text(sizeof write + static_cast<std::size_t>(write.old_bytes + write.new_bytes));
  std::memcpy(text.data(), &write, sizeof write);
  char* const old_bytes = text.data() + sizeof write;
  // The file may be open for writing alone.
  const std::string path = "/proc/self/fd/" + std::to_string(file);
  const int reader = real().open(path.c_str(), O_RDONLY | O_CLOEXEC);
  const auto wanted = static_cast<std::size_t>(write.old_bytes);
  if (::pread64(reader, old_bytes, wanted, write.offset) != write.old_bytes) std::abort();
  real().close(reader);
  if (bytes != nullptr) std::memcpy(old_bytes + wanted, bytes, static_cast<std::size_t>(write.new_bytes));
  if (real().write(log, text.data(), text.size()) != static_cast<ssize_t>(text.size())) std::abort();
}

int synced(int file, int (*sync)(int)) {
  const std::lock_guard lock{mutex};
  const int result = sync(file);
  if (result == 0 && log_of(file) != kNone && real().truncate(log_of(file), 0) != 0) std::abort();
  return result;
}

}  // namespace

extern "C" {

int open64(const char* path, int flags, ...) {
  va_list more;
  va_start(more, flags);
  const int mode = (flags & (O_CREAT | O_TMPFILE)) != 0 ? va_arg(more, int) : 0;
  va_end(more);
  const int file = real().open(path, flags, mode);
  if ((flags & O_ACCMODE) != O_RDONLY) watch(file, path);
  return file;
}
int open(const char* path, int flags, ...) __attribute__((alias("open64")));

int close(int file) {
  if (log_of(file) != kNone) {
    const std::lock_guard lock{mutex};
    real().close(std::exchange(logs[static_cast<std::size_t>(file)], kNone));
  }
  return real().close(file);
}

ssize_t pwrite64(int file, const void* bytes, size_t size, off64_t offset) {
  if (log_of(file) == kNone) return real().pwrite(file, bytes, size, offset);
  const std::lock_guard lock{mutex};
  note(file, log_of(file), {.offset = offset, .new_bytes = static_cast<std::int64_t>(size)}, bytes);
  return real().pwrite(file, bytes, size, offset);
}
ssize_t pwrite(int file, const void* bytes, size_t size, off_t offset) __attribute__((alias("pwrite64")));

ssize_t write(int file, const void* bytes, size_t size) {
  if (log_of(file) == kNone) return real().write(file, bytes, size);
  const std::lock_guard lock{mutex};
  const bool appends = (::fcntl(file, F_GETFL) & O_APPEND) != 0;
  const off64_t offset = appends ? size_of(file) : ::lseek64(file, 0, SEEK_CUR);
  note(file, log_of(file), {.offset = offset, .new_bytes = static_cast<std::int64_t>(size)}, bytes);
  return real().write(file, bytes, size);
}

int ftruncate64(int file, off64_t size) {
  if (log_of(file) == kNone) return real().truncate(file, size);
  const std::lock_guard lock{mutex};
  note(file, log_of(file), {.offset = size, .is_truncation = 1}, nullptr);
  return real().truncate(file, size);
}
int ftruncate(int file, off_t size) __attribute__((alias("ftruncate64")));

int fsync(int file) { return synced(file, real().fsync); }
int fdatasync(int file) { return synced(file, real().fdatasync); }

/// What is away is taken to stay away.
int unlink(const char* path) {
  if (is_watched(path)) real().unlink((path + std::string{truepose::test::kLogSuffix}).c_str());
  return real().unlink(path);
}

}  // extern "C"
