#include "config/text_file.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>

namespace truepose::config {

bool synced(const std::filesystem::path& path) {
  const int opened = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (opened < 0) return false;
  const bool done = ::fsync(opened) == 0;
  const int error = errno;
  ::close(opened);
  errno = error;
  return done;
}

std::ifstream open_to_read(const std::filesystem::path& file) {
  // A folder opens like a file and only fails to be read.
  if (std::error_code ignored; std::filesystem::is_directory(file, ignored)) {
    throw ConfigError(file.string() + ": is a folder, expected a file");
  }
  errno = 0;
  std::ifstream in(file, std::ios::binary);
  if (!in) throw ConfigError(file.string() + ": cannot be opened: " + std::strerror(errno));
  return in;
}

namespace {

bool is_own(const struct stat& found) { return S_ISREG(found.st_mode) && found.st_uid == ::geteuid(); }

}  // namespace

bool is_own_file(const std::filesystem::path& file) {
  struct stat found {};
  return ::lstat(file.c_str(), &found) == 0 && is_own(found);
}

std::ifstream open_own_to_read(const std::filesystem::path& file) {
  // Without waiting for what would be written to a pipe.
  const int opened = ::open(file.c_str(), O_RDONLY | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK);
  if (opened < 0) throw ConfigError(file.string() + ": cannot be opened: " + std::strerror(errno));
  struct stat found {};
  const bool own = ::fstat(opened, &found) == 0 && is_own(found);
  std::ifstream in;
  if (own) in.open("/proc/self/fd/" + std::to_string(opened), std::ios::binary);
  ::close(opened);
  if (!own) throw ConfigError(file.string() + ": is no file of our own, and is not read");
  if (!in) throw ConfigError(file.string() + ": cannot be opened: " + std::strerror(errno));
  return in;
}

std::string read_bytes(const std::filesystem::path& file, std::size_t most) {
  std::ifstream in = open_to_read(file);
  std::string text;
  std::array<char, 64 * 1024> block;
  do {
    in.read(block.data(), block.size());
    text.append(block.data(), static_cast<std::size_t>(in.gcount()));
    if (text.size() > most) {
      throw ConfigError(file.string() + ": has more than " + std::to_string(most >> 20U) +
                        " MiB, the most that is read of such a file");
    }
  } while (in);
  if (in.bad()) throw ConfigError(file.string() + ": cannot be read: " + std::strerror(errno));
  return text;
}

std::string read_text_file(const std::filesystem::path& file, std::size_t most) {
  std::string text = read_bytes(file, most);
  if (text.starts_with("\xEF\xBB\xBF")) text.erase(0, 3);
  return text;
}

void write_text_file(const std::filesystem::path& file, const std::string& text) {
  write_together({{file, text}});
}

std::filesystem::path folder_of(const std::filesystem::path& file) {
  return file.has_parent_path() ? file.parent_path() : std::filesystem::path{"."};
}

UnfinishedFile::UnfinishedFile(const std::filesystem::path& path) : path_(path) {
  std::error_code ignored;
  if (std::filesystem::is_directory(path, ignored))
    throw ConfigError(path.string() + ": is a folder, expected a file");
  const bool is_there = std::filesystem::exists(path, ignored);
  if (!is_there || std::filesystem::is_regular_file(path, ignored)) {
    // Of a link the file is replaced, and not the link.
    if (is_there) path_ = std::filesystem::canonical(path, ignored);
    temporary_ = path_.string() + "." + std::to_string(getpid());
  }
  errno = 0;
  if (temporary_.empty()) {
    out_.open(path_, std::ios::binary | std::ios::trunc);
  } else {
    // A new file: a link that another program has put there is not followed.
    std::filesystem::remove(temporary_, ignored);
    out_.open(temporary_, std::ios::binary | std::ios::noreplace);
  }
  if (!out_) fail();
  if (!temporary_.empty() && is_there) {
    // No more open than the one that it replaces, nor than any that is made here.
    using std::filesystem::status;
    std::filesystem::permissions(temporary_, status(path_).permissions() & status(temporary_).permissions());
  }
}

UnfinishedFile::~UnfinishedFile() {
  std::error_code ignored;
  if (!temporary_.empty()) std::filesystem::remove(temporary_, ignored);
}

void UnfinishedFile::close() {
  if (out_) errno = 0;  // else it says why the writing failed
  out_.close();
  if (!out_ || (!temporary_.empty() && !synced(temporary_))) fail();
}

void UnfinishedFile::take_place() {
  if (temporary_.empty()) return;
  std::error_code error;
  std::filesystem::rename(temporary_, path_, error);
  if (error) throw ConfigError(path_.string() + ": cannot be written: " + error.message());
  temporary_.clear();
  if (!synced(folder_of(path_))) fail();
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
