#include "daemon/service/lock_file.hpp"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <utility>

namespace truepose::daemon {

namespace {

/// "trueposed (process 1234)", from the number that the holder wrote into the file.
std::string holder(int descriptor) {
  std::array<char, 32> text{};
  const ssize_t size = ::pread(descriptor, text.data(), text.size() - 1, 0);
  const std::string pid{text.data(), static_cast<std::size_t>(size > 0 ? size : 0)};
  if (pid.empty() || pid.find_first_not_of("0123456789") != std::string::npos) return "another process";
  std::string name = "another";
  std::ifstream comm{"/proc/" + pid + "/comm"};
  std::getline(comm, name);
  return name + " (process " + pid + ")";
}

}  // namespace

std::expected<LockFile, drivers::StartFailure> LockFile::take(const std::filesystem::path& file,
                                                              const std::string& of) {
  const auto failed = [&](int error) {
    const bool full = error == ENOSPC || error == EDQUOT;
    return std::unexpected(drivers::StartFailure{file.string() + ": " + std::strerror(error), full});
  };
  LockFile lock{::open(file.c_str(), O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW, 0600)};
  if (lock.descriptor_ < 0) return failed(errno);
  if (::flock(lock.descriptor_, LOCK_EX | LOCK_NB) != 0) {
    if (errno != EWOULDBLOCK) return failed(errno);
    return std::unexpected(
        drivers::StartFailure{of + " is in use by " + holder(lock.descriptor_) +
                                  ": a cell has one daemon, and each its own store and folder",
                              true});
  }
  const std::string pid = std::to_string(::getpid());
  // The number is for a sentence alone: on a full disk the lock is as good without it.
  const bool written =
      ::ftruncate(lock.descriptor_, 0) == 0 &&
      ::pwrite(lock.descriptor_, pid.data(), pid.size(), 0) == static_cast<ssize_t>(pid.size());
  static_cast<void>(written);
  return lock;
}

LockFile::LockFile(LockFile&& other) noexcept : descriptor_{std::exchange(other.descriptor_, -1)} {}

LockFile::~LockFile() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

std::filesystem::path lock_of_store(const std::filesystem::path& store) {
  std::error_code unknown;
  std::filesystem::path file = std::filesystem::weakly_canonical(store, unknown);
  if (unknown) file = store;
  file += ".lock";
  return file;
}

}  // namespace truepose::daemon
