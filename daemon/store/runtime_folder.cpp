#include "daemon/store/runtime_folder.hpp"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <utility>

#include "config/text_file.hpp"

namespace truepose::daemon {

namespace {

namespace fs = std::filesystem;

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

std::string from_environment(const char* name) {
  const char* const value = std::getenv(name);
  return value ? value : "";
}

/// The cell's name as the name of one folder.
std::string folder_name(std::string name) {
  for (char& letter : name) {
    const bool plain = (letter >= '0' && letter <= '9') || (letter >= 'a' && letter <= 'z') ||
                       (letter >= 'A' && letter <= 'Z') || letter == '-' || letter == '_';
    if (!plain) letter = '-';
  }
  return name;
}

fs::path chosen_folder(const config::CellConfig& config, const RuntimePlaces& places) {
  if (!config.runtime.empty()) return config.runtime;
  // A unit may have several, separated by colons: the first is the cell's.
  if (!places.unit.empty()) return places.unit.substr(0, places.unit.find(':'));
  const std::string name = folder_name(config.name);
  if (!places.user.empty()) return places.user / ("truepose-" + name);
  return places.system / name;
}

}  // namespace

std::expected<LockFile, drivers::StartFailure> LockFile::take(const fs::path& file, const std::string& of) {
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

fs::path lock_of_store(const fs::path& store) {
  std::error_code unknown;
  fs::path file = fs::weakly_canonical(store, unknown);
  if (unknown) file = store;
  file += ".lock";
  return file;
}

RuntimePlaces RuntimePlaces::of_environment() {
  return {.unit = from_environment("RUNTIME_DIRECTORY"), .user = from_environment("XDG_RUNTIME_DIR")};
}

std::expected<fs::path, std::string> runtime_folder(const config::CellConfig& config,
                                                    const RuntimePlaces& places) {
  const fs::path folder = chosen_folder(config, places);
  const auto bad = [&](const std::string& why) {
    return std::unexpected("runtime folder " + folder.string() + ": " + why +
                           "; name another with the cell file's key runtime");
  };
  std::error_code error;
  fs::create_directories(config::folder_of(folder), error);
  // Created with its mode: no other user can enter before it is set.
  if (!error && ::mkdir(folder.c_str(), 0750) != 0 && errno != EEXIST)
    error = {errno, std::system_category()};
  if (error) return bad("cannot be made (" + error.message() + ")");

  struct stat found {};
  if (::lstat(folder.c_str(), &found) != 0) return bad(std::strerror(errno));
  if (!S_ISDIR(found.st_mode)) return bad("is no folder");
  // Another user that may write there could replace our control socket.
  if (found.st_uid != ::geteuid()) return bad("belongs to another user");
  if ((found.st_mode & (S_IWGRP | S_IWOTH)) != 0)
    return bad("others may write there; run: chmod 750 " + folder.string());
  return folder;
}

}  // namespace truepose::daemon
