#include "config/unfinished_file.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "config/config_error.hpp"

namespace truepose::config {
namespace {

/// Puts a file, or the names in a folder, on the disk. @return false with errno where that fails
bool synced(const std::filesystem::path& path) {
  const int opened = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (opened < 0) return false;
  const bool done = ::fsync(opened) == 0;
  const int error = errno;
  ::close(opened);
  errno = error;
  return done;
}

}  // namespace

UnfinishedFile::UnfinishedFile(const std::filesystem::path& path) : path_(path) {
  std::error_code ignored;
  if (std::filesystem::is_directory(path, ignored))
    throw ConfigError(path.string() + ": is a folder, expected a file");
  const bool is_there = std::filesystem::exists(path, ignored);
  if (!is_there || std::filesystem::is_regular_file(path, ignored)) {
    // Of a link the file is replaced, and not the link.
    if (is_there) path_ = std::filesystem::canonical(path, ignored);
    beside_ = path_.string() + "." + std::to_string(getpid());
  }
  errno = 0;
  out_.open(beside_.empty() ? path_ : beside_, std::ios::binary | std::ios::trunc);
  if (!out_) fail();
}

UnfinishedFile::~UnfinishedFile() {
  std::error_code ignored;
  if (!beside_.empty()) std::filesystem::remove(beside_, ignored);
}

void UnfinishedFile::close() {
  if (out_) errno = 0;  // else it says why the writing failed
  out_.close();
  if (!out_ || (!beside_.empty() && !synced(beside_))) fail();
}

void UnfinishedFile::take_place() {
  if (beside_.empty()) return;
  std::error_code error;
  std::filesystem::rename(beside_, path_, error);
  if (error) throw ConfigError(path_.string() + ": cannot be written: " + error.message());
  beside_.clear();
  if (!synced(path_.has_parent_path() ? path_.parent_path() : ".")) fail();
}

void UnfinishedFile::fail() const {
  throw ConfigError(path_.string() + ": cannot be written: " + std::strerror(errno));
}

void write_together(const std::vector<TextFile>& files) {
  // What would keep a file from its place is found before the first takes its own.
  std::vector<UnfinishedFile> unfinished;
  for (const TextFile& file : files) {
    unfinished.emplace_back(file.path).stream() << file.text;
    unfinished.back().close();
  }
  for (UnfinishedFile& file : unfinished) file.take_place();
}

}  // namespace truepose::config
