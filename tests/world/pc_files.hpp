#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "core/math/random.hpp"
#include "tests/daemon/failing_disk.hpp"

namespace truepose::world {

/// What a loss of power leaves of the files in a folder. While it lives, fsync() and fdatasync() of this
/// process are defined here: they note the bytes of a file, and the names in a folder. At a loss of power
/// each file and each folder goes back to what was noted last; by chance it keeps the present bytes, their
/// first sectors, or the present names. A file of SQLite has its bytes on the disk in memory, and its name
/// here.
class PcFiles {
 public:
  /// @param folder   what is in it counts as synced
  /// @param runtime  a folder in it that is in memory, and on no disk; a loss of power takes it
  PcFiles(const std::filesystem::path& folder, const std::filesystem::path& runtime, std::uint64_t seed,
          test::FailingDisk& disk);
  ~PcFiles();
  PcFiles(const PcFiles&) = delete;
  PcFiles& operator=(const PcFiles&) = delete;

  /// Once no process has a file open. The bytes of SQLite's files lose the power with their disk.
  void lose_power();

  /// How many of them this class holds open.
  std::size_t open() const { return files_.size(); }
  bool has(const std::filesystem::path& path) const;
  /// A change of one of these files. @return 0 or errno
  int change(bool takes_room) { return disk_.change(takes_room); }
  /// As fsync() does with one of these files or folders. @return 0 or errno
  int sync(int descriptor);

 private:
  struct File;
  /// Names in a folder; null: a folder.
  using Names = std::map<std::string, std::shared_ptr<File>>;

  void note_all();
  std::shared_ptr<File> file_at(const std::filesystem::path& path);
  Names names_in(const std::filesystem::path& folder);
  void forget_removed();
  void lose_names(const std::filesystem::path& folder);
  void bring_back(File& file, const std::filesystem::path& path);
  void lose_bytes(File& file);

  const std::filesystem::path folder_, runtime_;
  Random random_;
  test::FailingDisk& disk_;
  std::vector<std::shared_ptr<File>> files_;
  std::map<std::filesystem::path, Names> synced_;  ///< by their folders
};

}  // namespace truepose::world
