#include "tools/truepose/unfinished_file.hpp"

#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "config/config_error.hpp"

namespace truepose::tools {

UnfinishedFile::UnfinishedFile(const std::filesystem::path& path) : path_(path) {
  std::error_code ignored;
  if (std::filesystem::is_directory(path, ignored))
    throw config::ConfigError(path.string() + ": is a folder, expected a file");
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
  errno = 0;
  out_.close();
  if (!out_) fail();
}

void UnfinishedFile::take_place() {
  if (beside_.empty()) return;
  std::error_code error;
  std::filesystem::rename(beside_, path_, error);
  if (error) throw config::ConfigError(path_.string() + ": cannot be written: " + error.message());
  beside_.clear();
}

void UnfinishedFile::fail() const {
  throw config::ConfigError(path_.string() + ": cannot be written: " + std::strerror(errno));
}

}  // namespace truepose::tools
