#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <random>
#include <vector>

struct sqlite3_vfs;

namespace truepose::test {

/// A disk under SQLite that can be full, fail, and lose its power: a file system of SQLite's, in memory,
/// which remembers of each file what was synced, and what was written since in which order.
///
/// It becomes SQLite's default file system for as long as it lives: every store that is opened then is on it,
/// whatever its path. Bytes are in memory, names on the real disk, where the files are empty: they can be
/// renamed, linked and removed there.
class FailingDisk {
 public:
  struct File;

  explicit FailingDisk(std::uint64_t seed = 0);
  ~FailingDisk();
  FailingDisk(const FailingDisk&) = delete;
  FailingDisk& operator=(const FailingDisk&) = delete;

  /// What an operation that changes something ends with from now on.
  enum class Fault { None, Full, Broken, ReadOnly };
  /// The first `count` changes from now on succeed, and the `faults` after that fail.
  void fail_after(int count, Fault fault, int faults = 1'000'000);
  void repair() { fail_after(0, Fault::None, 0); }
  /// Writes, truncations and syncs since fail_after().
  int changes() const { return changes_; }

  /// The power goes at once: from now on nothing comes to the disk, and every change fails.
  void cut_power() { powerless_ = true; }
  /// After that, and once every connection is closed: of each file stays what was synced, and by chance some
  /// of what was written since: in the order of writing or not, whole, or the last one torn at a sector.
  void restore_power();
  /// The same where only the process was killed: what it had written stays.
  void restore_process();

  /// A change of a file that is not SQLite's. @param takes_room  of the disk: a full one refuses it
  /// @return 0, ENOSPC, EIO or EROFS
  int change(bool takes_room);
  std::size_t files() const { return files_.size(); }
  /// The bytes behind a file of the real disk; null: SQLite has none there.
  std::shared_ptr<File> file_at(const std::filesystem::path& path) const;
  /// Puts them behind another one, where the file system has removed theirs.
  static void move(File& file, const std::filesystem::path& path);
  /// As fsync().
  static void sync(File& file);
  /// SQLite syncs the folder of a log with its first bytes, and where it has removed one.
  std::function<void(const std::filesystem::path& folder)> on_folder_sync = [](const auto&) {};

 private:
  friend struct DiskFile;
  struct Write {
    std::int64_t offset;  ///< negative: the file is cut at ~offset
    std::vector<std::uint8_t> bytes;
  };
  using Files = std::vector<std::shared_ptr<File>>;

  /// The same of a file of SQLite's.
  /// @param full, broken  what it ends with otherwise
  int change(int full, int broken);
  std::shared_ptr<File> make_at(const std::filesystem::path& path);
  void write(File& file, Write change);
  void lose_unsynced(File& file);
  static void apply(const Write& write, std::vector<std::uint8_t>& bytes);

  std::mt19937_64 random_;
  Files files_;  ///< in the order in which they were made
  Fault fault_ = Fault::None;
  int healthy_ = 0, faults_ = 0, changes_ = 0;
  bool powerless_ = false;
  int reason_ = 0;  ///< of the last failure, as the system would say it
  std::unique_ptr<sqlite3_vfs> vfs_;
  sqlite3_vfs* real_;
};

}  // namespace truepose::test
