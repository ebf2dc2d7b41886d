#include "tests/daemon/failing_disk.hpp"

#include <fcntl.h>
#include <sqlite3.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <new>
#include <utility>

#include "tests/daemon_heap.hpp"

namespace truepose::test {

namespace {

constexpr std::int64_t kSector = 512;

}  // namespace

struct FailingDisk::File {
  ~File() {
    if (place >= 0) ::close(place);
  }
  int place = -1;  ///< the empty file of the real disk, open: no other file can have its number
  std::vector<std::uint8_t> synced{}, now{};
  std::vector<Write> since{};
  int opened = 0;         ///< how many connections hold it at all
  bool reserved = false;  ///< one of them writes
  std::vector<std::vector<std::uint8_t>> shared_memory{};
};

/// What SQLite has of a file that it opened.
struct DiskFile {
  sqlite3_file base{};
  FailingDisk* disk = nullptr;
  std::shared_ptr<FailingDisk::File> file{};
  int lock = SQLITE_LOCK_NONE;
  std::filesystem::path unsynced_folder{};  // of a log that is new

  static DiskFile& of(sqlite3_file* file) { return *reinterpret_cast<DiskFile*>(file); }
  static FailingDisk& disk_of(sqlite3_vfs* vfs) { return *static_cast<FailingDisk*>(vfs->pAppData); }
  static sqlite3_vfs* real(sqlite3_vfs* vfs) { return disk_of(vfs).real_; }

  static int close(sqlite3_file* f) {
    unlock(f, SQLITE_LOCK_NONE);
    of(f).~DiskFile();
    return SQLITE_OK;
  }
  static int read(sqlite3_file* f, void* to, int size, sqlite3_int64 offset) {
    const std::vector<std::uint8_t>& bytes = of(f).file->now;
    const auto begin = std::min(static_cast<std::size_t>(offset), bytes.size());
    const std::size_t there = std::min(static_cast<std::size_t>(size), bytes.size() - begin);
    std::memset(to, 0, static_cast<std::size_t>(size));
    if (there > 0) std::memcpy(to, bytes.data() + begin, there);
    return there == static_cast<std::size_t>(size) ? SQLITE_OK : SQLITE_IOERR_SHORT_READ;
  }
  static int write(sqlite3_file* f, const void* from, int size, sqlite3_int64 offset) {
    const int code = of(f).disk->change(SQLITE_FULL, SQLITE_IOERR_WRITE);
    if (code != SQLITE_OK) return code;
    const AllocatesFor world{AllocatesFor::World};
    const auto* const bytes = static_cast<const std::uint8_t*>(from);
    of(f).disk->write(*of(f).file, {offset, {bytes, bytes + size}});
    return SQLITE_OK;
  }
  static int truncate(sqlite3_file* f, sqlite3_int64 size) {
    const int code = of(f).disk->change(SQLITE_OK, SQLITE_IOERR_TRUNCATE);
    if (code != SQLITE_OK) return code;
    const AllocatesFor world{AllocatesFor::World};
    of(f).disk->write(*of(f).file, {~size, {}});
    return SQLITE_OK;
  }
  static int sync(sqlite3_file* f, int) {
    const int code = of(f).disk->change(SQLITE_OK, SQLITE_IOERR_FSYNC);
    if (code != SQLITE_OK) return code;
    const AllocatesFor world{AllocatesFor::World};
    FailingDisk::sync(*of(f).file);
    const std::filesystem::path folder = std::exchange(of(f).unsynced_folder, {});
    if (!folder.empty()) of(f).disk->on_folder_sync(folder);
    return SQLITE_OK;
  }
  static int size(sqlite3_file* f, sqlite3_int64* bytes) {
    *bytes = static_cast<sqlite3_int64>(of(f).file->now.size());
    return SQLITE_OK;
  }
  static int take_lock(sqlite3_file* f, int wanted) {
    DiskFile& self = of(f);
    if (wanted <= self.lock) return SQLITE_OK;
    FailingDisk::File& file = *self.file;
    if (wanted == SQLITE_LOCK_SHARED) {
      ++file.opened;
    } else {
      const bool others = file.opened > 1;
      const bool mine = self.lock >= SQLITE_LOCK_RESERVED;
      if (file.reserved && !mine) return SQLITE_BUSY;
      if (wanted == SQLITE_LOCK_EXCLUSIVE && others) return SQLITE_BUSY;
      file.reserved = true;
    }
    self.lock = wanted;
    return SQLITE_OK;
  }
  static int unlock(sqlite3_file* f, int wanted) {
    DiskFile& self = of(f);
    if (self.lock <= wanted) return SQLITE_OK;
    if (self.lock >= SQLITE_LOCK_RESERVED && wanted < SQLITE_LOCK_RESERVED) self.file->reserved = false;
    if (wanted == SQLITE_LOCK_NONE) --self.file->opened;
    self.lock = wanted;
    return SQLITE_OK;
  }
  static int is_reserved(sqlite3_file* f, int* reserved) {
    *reserved = of(f).file->reserved ? 1 : 0;
    return SQLITE_OK;
  }
  static int control(sqlite3_file*, int, void*) { return SQLITE_NOTFOUND; }
  static int sector(sqlite3_file*) { return kSector; }
  static int characteristics(sqlite3_file*) { return 0; }
  static int map_shared(sqlite3_file* f, int region, int size, int extend, void volatile** memory) {
    auto& regions = of(f).file->shared_memory;
    *memory = nullptr;
    while (extend != 0 && static_cast<int>(regions.size()) <= region) {
      const AllocatesFor world{AllocatesFor::World};
      const int code = of(f).disk->change(SQLITE_IOERR_SHMSIZE, SQLITE_IOERR_SHMSIZE);
      if (code != SQLITE_OK) return code;
      regions.emplace_back(static_cast<std::size_t>(size));
    }
    if (static_cast<int>(regions.size()) > region) *memory = regions[static_cast<std::size_t>(region)].data();
    return SQLITE_OK;
  }
  // Connections of one thread, none in the middle of anything while another is used: nobody has to wait.
  static int lock_shared(sqlite3_file*, int, int, int) { return SQLITE_OK; }
  static void barrier(sqlite3_file*) {}
  static int unmap_shared(sqlite3_file* f, int remove) {
    if (remove != 0) of(f).file->shared_memory.clear();
    return SQLITE_OK;
  }

  static const sqlite3_io_methods* methods() {
    static const sqlite3_io_methods kMethods{
        .iVersion = 2,
        .xClose = &close,
        .xRead = &read,
        .xWrite = &write,
        .xTruncate = &truncate,
        .xSync = &sync,
        .xFileSize = &size,
        .xLock = &take_lock,
        .xUnlock = &unlock,
        .xCheckReservedLock = &is_reserved,
        .xFileControl = &control,
        .xSectorSize = &sector,
        .xDeviceCharacteristics = &characteristics,
        .xShmMap = &map_shared,
        .xShmLock = &lock_shared,
        .xShmBarrier = &barrier,
        .xShmUnmap = &unmap_shared,
        .xFetch = nullptr,
        .xUnfetch = nullptr,
    };
    return &kMethods;
  }

  static int open(sqlite3_vfs* vfs, const char* name, sqlite3_file* f, int flags, int* opened_with) {
    const AllocatesFor world{AllocatesFor::World};
    FailingDisk& disk = disk_of(vfs);
    auto* const made = new (f) DiskFile{};
    if (opened_with != nullptr) *opened_with = flags;
    if (name == nullptr) {
      made->file = std::make_shared<FailingDisk::File>();
    } else {
      made->file = disk.file_at(name);
      const bool is_log = (flags & (SQLITE_OPEN_WAL | SQLITE_OPEN_MAIN_JOURNAL)) != 0;
      if (!made->file && is_log) made->unsynced_folder = std::filesystem::path{name}.parent_path();
      if (!made->file) made->file = disk.make_at(name);
      if (!made->file) {
        of(f).~DiskFile();
        f->pMethods = nullptr;
        return SQLITE_CANTOPEN;
      }
    }
    made->disk = &disk;
    made->base.pMethods = methods();
    return SQLITE_OK;
  }
  static int remove(sqlite3_vfs* vfs, const char* name, int syncs_folder) {
    const int code = disk_of(vfs).change(SQLITE_OK, SQLITE_IOERR_DELETE);
    if (code != SQLITE_OK) return code;
    ::unlink(name);
    if (syncs_folder != 0) disk_of(vfs).on_folder_sync(std::filesystem::path{name}.parent_path());
    return SQLITE_OK;
  }
  static int access(sqlite3_vfs* vfs, const char* name, int, int* there) {
    *there = disk_of(vfs).file_at(name) ? 1 : 0;
    return SQLITE_OK;
  }
  static int full_path(sqlite3_vfs* vfs, const char* name, int size, char* path) {
    return real(vfs)->xFullPathname(real(vfs), name, size, path);
  }
  static int randomness(sqlite3_vfs* vfs, int size, char* bytes) {
    for (int i = 0; i < size; ++i) bytes[i] = static_cast<char>(disk_of(vfs).random_());
    return size;
  }
  static int sleep(sqlite3_vfs*, int us) { return us; }
  static int time(sqlite3_vfs* vfs, double* now) { return real(vfs)->xCurrentTime(real(vfs), now); }
  static int last_error(sqlite3_vfs* vfs, int, char*) { return disk_of(vfs).reason_; }
};

FailingDisk::FailingDisk(std::uint64_t seed)
    : random_{seed}, vfs_{std::make_unique<sqlite3_vfs>()}, real_{sqlite3_vfs_find(nullptr)} {
  vfs_->iVersion = 1;
  vfs_->szOsFile = sizeof(DiskFile);
  vfs_->mxPathname = real_->mxPathname;
  vfs_->zName = "failing-disk";
  vfs_->pAppData = this;
  vfs_->xOpen = &DiskFile::open;
  vfs_->xDelete = &DiskFile::remove;
  vfs_->xAccess = &DiskFile::access;
  vfs_->xFullPathname = &DiskFile::full_path;
  vfs_->xRandomness = &DiskFile::randomness;
  vfs_->xSleep = &DiskFile::sleep;
  vfs_->xCurrentTime = &DiskFile::time;
  vfs_->xGetLastError = &DiskFile::last_error;
  sqlite3_vfs_register(vfs_.get(), 1);
}

FailingDisk::~FailingDisk() {
  sqlite3_vfs_unregister(vfs_.get());
  sqlite3_vfs_register(real_, 1);
}

void FailingDisk::fail_after(int count, Fault fault, int faults) {
  healthy_ = count;
  fault_ = fault;
  faults_ = faults;
  changes_ = 0;
}

int FailingDisk::change(bool takes_room) {
  if (powerless_) return EIO;
  ++changes_;
  if (fault_ == Fault::None || changes_ <= healthy_ || changes_ > healthy_ + faults_) return 0;
  if (fault_ == Fault::Broken) return EIO;
  if (fault_ == Fault::ReadOnly) return EROFS;
  return takes_room ? ENOSPC : 0;
}

int FailingDisk::change(int full, int broken) {
  const int failed = change(full != SQLITE_OK);
  if (failed == 0) return SQLITE_OK;
  reason_ = failed;
  return failed == ENOSPC ? full : broken;
}

std::shared_ptr<FailingDisk::File> FailingDisk::file_at(const std::filesystem::path& path) const {
  struct stat there {};
  if (::stat(path.c_str(), &there) != 0) return nullptr;
  const auto is_there = [&](const std::shared_ptr<File>& file) {
    struct stat place {};
    return ::fstat(file->place, &place) == 0 && place.st_ino == there.st_ino && place.st_dev == there.st_dev;
  };
  const auto found = std::ranges::find_if(files_, is_there);
  return found == files_.end() ? nullptr : *found;
}

std::shared_ptr<FailingDisk::File> FailingDisk::make_at(const std::filesystem::path& path) {
  const auto is_gone = [](const std::shared_ptr<File>& file) {
    struct stat place {};
    return file.use_count() == 1 && ::fstat(file->place, &place) == 0 && place.st_nlink == 0;
  };
  std::erase_if(files_, is_gone);
  auto file = std::make_shared<File>();
  move(*file, path);
  if (file->place < 0) return nullptr;
  files_.push_back(file);
  return file;
}

void FailingDisk::move(File& file, const std::filesystem::path& path) {
  if (file.place >= 0) ::close(file.place);
  file.place = ::open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, S_IRUSR | S_IWUSR);
}

void FailingDisk::sync(File& file) {
  for (const Write& write : file.since) apply(write, file.synced);
  file.since.clear();
}

void FailingDisk::write(File& file, Write change) {
  apply(change, file.now);
  file.since.push_back(std::move(change));
}

void FailingDisk::apply(const Write& write, std::vector<std::uint8_t>& bytes) {
  if (write.offset < 0) {
    bytes.resize(static_cast<std::size_t>(~write.offset));
    return;
  }
  const auto begin = static_cast<std::size_t>(write.offset);
  bytes.resize(std::max(bytes.size(), begin + write.bytes.size()));
  std::ranges::copy(write.bytes, bytes.begin() + write.offset);
}

void FailingDisk::lose_unsynced(File& file) {
  std::vector<std::uint8_t> left = file.synced;
  const bool in_order = random_() % 2 == 0;
  std::size_t whole = file.since.empty() ? 0 : random_() % (file.since.size() + 1);
  for (std::size_t i = 0; i < file.since.size(); ++i) {
    Write write = file.since[i];
    const bool torn = in_order ? i == whole : random_() % 8 == 0;
    const bool lost = in_order ? i > whole : random_() % 2 == 0;
    if (lost && !torn) continue;
    if (torn) {
      if (write.offset < 0) continue;
      const std::size_t sectors = write.bytes.size() / kSector;
      write.bytes.resize(sectors == 0 ? 0 : random_() % (sectors + 1) * kSector);
      if (write.bytes.empty()) continue;
    }
    apply(write, left);
  }
  file.now = file.synced = std::move(left);
  file.since.clear();
}

void FailingDisk::restore_power() {
  for (const auto& file : files_) lose_unsynced(*file);
  restore_process();
}

void FailingDisk::restore_process() {
  powerless_ = false;
  for (const auto& file : files_) {
    file->shared_memory.clear();
    file->opened = 0;
    file->reserved = false;
  }
}

}  // namespace truepose::test
