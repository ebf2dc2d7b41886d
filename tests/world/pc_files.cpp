#include "tests/world/pc_files.hpp"

#include <dlfcn.h>
#include <fcntl.h>
#include <sys/stat.h>
#include <sys/uio.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <set>
#include <system_error>
#include <utility>

#include "tests/daemon_heap.hpp"

namespace truepose::world {

namespace fs = std::filesystem;

namespace {

constexpr std::size_t kSector = 512;

PcFiles* files_of_the_pc = nullptr;

struct stat status_of(int descriptor) {
  struct stat found {};
  ::fstat(descriptor, &found);
  return found;
}

std::string link_to(int descriptor) { return "/proc/self/fd/" + std::to_string(descriptor); }

std::string bytes_of(int descriptor) {
  std::string bytes(static_cast<std::size_t>(status_of(descriptor).st_size), '\0');
  const ssize_t size = ::pread(descriptor, bytes.data(), bytes.size(), 0);
  bytes.resize(size < 0 ? 0 : static_cast<std::size_t>(size));
  return bytes;
}

void write_all(int descriptor, const std::string& bytes) {
  const auto size = static_cast<off_t>(bytes.size());
  if (::pwrite(descriptor, bytes.data(), bytes.size(), 0) != size || ::ftruncate(descriptor, size) != 0)
    throw std::system_error{errno, std::system_category(), "a file of the PC"};
}

bool is_below(const fs::path& path, const fs::path& folder) {
  return std::ranges::mismatch(folder, path).in1 == folder.end();
}

fs::path path_of(int descriptor) {
  std::error_code none;
  return fs::read_symlink(link_to(descriptor), none);
}

bool is_of_the_pc(int descriptor) {
  return files_of_the_pc != nullptr && files_of_the_pc->has(path_of(descriptor));
}

bool is_of_the_pc(const char* name) {
  return files_of_the_pc != nullptr && files_of_the_pc->has(fs::absolute(name));
}

/// Whether a change of this file fails now, with errno set.
/// @param file  descriptor or name
template <typename File>
bool fails(File file, bool takes_room) {
  if (!is_of_the_pc(file)) return false;
  const int failed = files_of_the_pc->change(takes_room);
  if (failed != 0) errno = failed;
  return failed != 0;
}

/// What the C library has under this name.
template <typename Function>
Function* library(const char* name) {
  return reinterpret_cast<Function*>(::dlsym(RTLD_NEXT, name));
}

int sync_or_pass_on(const char* name, int descriptor) {
  if (!is_of_the_pc(descriptor)) return library<int(int)>(name)(descriptor);
  const int failed = files_of_the_pc->sync(descriptor);
  if (failed == 0) return 0;
  errno = failed;
  return -1;
}

}  // namespace

/// A file whatever its names are: it stays open, and no other can have its number.
struct PcFiles::File {
  explicit File(int open) : descriptor{open} {}
  ~File() { ::close(descriptor); }
  File(const File&) = delete;
  File& operator=(const File&) = delete;

  int descriptor;
  std::string synced{};
  std::shared_ptr<test::FailingDisk::File> of_sqlite{};
};

PcFiles::PcFiles(const fs::path& folder, const fs::path& runtime, std::uint64_t seed, test::FailingDisk& disk)
    : folder_{fs::canonical(folder)}, runtime_{folder_ / runtime}, random_{seed}, disk_{disk} {
  note_all();
  disk_.on_folder_sync = [this](const fs::path& of_log) {
    if (has(of_log)) synced_[of_log] = names_in(of_log);
  };
  files_of_the_pc = this;
}

PcFiles::~PcFiles() {
  files_of_the_pc = nullptr;
  disk_.on_folder_sync = [](const auto&) {};
}

void PcFiles::note_all() {
  synced_.clear();
  synced_[folder_] = names_in(folder_);
  for (const auto& entry : fs::recursive_directory_iterator{folder_})
    if (entry.is_directory()) synced_[entry.path()] = names_in(entry.path());
  for (const auto& file : files_) file->synced = bytes_of(file->descriptor);
  forget_removed();
}

std::shared_ptr<PcFiles::File> PcFiles::file_at(const fs::path& path) {
  const int opened = ::open(path.c_str(), O_RDWR | O_CLOEXEC | O_NOFOLLOW);
  if (opened < 0) throw std::system_error{errno, std::system_category(), path.string()};
  const auto made = std::make_shared<File>(opened);
  const auto found = std::ranges::find_if(files_, [&](const std::shared_ptr<File>& file) {
    return status_of(file->descriptor).st_ino == status_of(opened).st_ino;
  });
  const auto& file = found == files_.end() ? files_.emplace_back(made) : *found;
  if (!file->of_sqlite) file->of_sqlite = disk_.file_at(path);
  return file;
}

PcFiles::Names PcFiles::names_in(const fs::path& folder) {
  Names names;
  for (const auto& entry : fs::directory_iterator{folder}) {
    const std::string name = entry.path().filename();
    if (entry.is_directory()) names.emplace(name, nullptr);
    if (entry.is_regular_file()) names.emplace(name, file_at(entry.path()));
  }
  return names;
}

void PcFiles::forget_removed() {
  std::erase_if(files_, [](const std::shared_ptr<File>& file) {
    return file.use_count() == 1 && status_of(file->descriptor).st_nlink == 0;
  });
}

bool PcFiles::has(const fs::path& path) const { return is_below(path, folder_) && !is_below(path, runtime_); }

int PcFiles::sync(int descriptor) {
  const AllocatesFor world{AllocatesFor::World};
  if (const int failed = change(false); failed != 0) return failed;
  const fs::path path = path_of(descriptor);
  if (fs::is_directory(path)) {
    synced_[path] = names_in(path);
    forget_removed();
  } else if (fs::exists(path)) {
    const auto file = file_at(path);
    if (file->of_sqlite) test::FailingDisk::sync(*file->of_sqlite);
    file->synced = bytes_of(descriptor);
  }
  return 0;
}

void PcFiles::lose_power() {
  files_of_the_pc = nullptr;
  fs::remove_all(runtime_);
  lose_names(folder_);
  std::set<File*> seen;
  for (const auto& [folder, names] : synced_)
    for (const auto& [name, file] : names)
      if (file && seen.insert(file.get()).second) lose_bytes(*file);
  note_all();
  files_of_the_pc = this;
}

/// Leaves in `synced_` what is there then.
void PcFiles::lose_names(const fs::path& folder) {
  const Names before = synced_[folder], now = names_in(folder);
  const bool all_kept = random_.uniform() < 0.5;
  const auto is_as_before = [](const Names& names, const Names::value_type& entry) {
    const auto found = names.find(entry.first);
    return found != names.end() && found->second == entry.second;
  };
  for (const auto& entry : now)
    if (!all_kept && !is_as_before(before, entry)) fs::remove_all(folder / entry.first);
  for (const auto& entry : before)
    if (!all_kept && !is_as_before(now, entry) && entry.second)
      bring_back(*entry.second, folder / entry.first);
  synced_[folder] = names_in(folder);
  for (const auto& [name, file] : synced_[folder])
    if (!file) lose_names(folder / name);
}

void PcFiles::bring_back(File& file, const fs::path& path) {
  const struct stat was = status_of(file.descriptor);
  const std::string link = link_to(file.descriptor);
  if (was.st_nlink > 0 && ::linkat(AT_FDCWD, link.c_str(), AT_FDCWD, path.c_str(), AT_SYMLINK_FOLLOW) == 0)
    return;
  const std::string bytes = bytes_of(file.descriptor);
  ::close(file.descriptor);
  file.descriptor = ::open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, was.st_mode & 07777);
  write_all(file.descriptor, bytes);
  if (file.of_sqlite) test::FailingDisk::move(*file.of_sqlite, path);
}

void PcFiles::lose_bytes(File& file) {
  const std::string now = bytes_of(file.descriptor);
  if (file.of_sqlite || now == file.synced) return;
  const double which = random_.uniform(), sectors = random_.uniform();
  if (which < 0.25) return;
  std::string left = file.synced;
  if (which < 0.5) {
    const auto count = static_cast<std::size_t>(sectors * static_cast<double>(now.size() / kSector + 1));
    const std::size_t torn = std::min(now.size(), count * kSector);
    left.resize(std::max(left.size(), torn));
    std::copy_n(now.begin(), torn, left.begin());
  }
  write_all(file.descriptor, left);
}

}  // namespace truepose::world

// Of the C library: this program's own stand before them.

using truepose::world::fails;
using truepose::world::library;
using truepose::world::sync_or_pass_on;

extern "C" {

int fsync(int file) { return sync_or_pass_on("fsync", file); }
int fdatasync(int file) { return sync_or_pass_on("fdatasync", file); }

ssize_t write(int file, const void* bytes, std::size_t size) {
  if (fails(file, true)) return -1;
  return library<ssize_t(int, const void*, std::size_t)>("write")(file, bytes, size);
}

ssize_t writev(int file, const struct iovec* parts, int count) {
  if (fails(file, true)) return -1;
  return library<ssize_t(int, const struct iovec*, int)>("writev")(file, parts, count);
}

ssize_t pwrite(int file, const void* bytes, std::size_t size, off_t offset) {
  if (fails(file, true)) return -1;
  return library<ssize_t(int, const void*, std::size_t, off_t)>("pwrite")(file, bytes, size, offset);
}

int posix_fallocate(int file, off_t offset, off_t size) {
  if (fails(file, true)) return errno;
  return library<int(int, off_t, off_t)>("posix_fallocate")(file, offset, size);
}

int ftruncate(int file, off_t size) noexcept {
  if (fails(file, false)) return -1;
  return library<int(int, off_t)>("ftruncate")(file, size);
}

int rename(const char* from, const char* to) noexcept {
  if (fails(from, false)) return -1;
  return library<int(const char*, const char*)>("rename")(from, to);
}

int remove(const char* name) noexcept {
  if (fails(name, false)) return -1;
  return library<int(const char*)>("remove")(name);
}

}  // extern "C"
