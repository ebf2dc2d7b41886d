#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>

#include "daemon/store/store_error.hpp"

struct sqlite3_backup;

namespace truepose::daemon {
namespace sqlite {
class Database;
}

/// Makes a copy of a store, some pages at a time. A write meanwhile waits for one step at most, and is in the
/// copy. Only its owner can read the file. Until it is complete and synced, it has another name in the same
/// folder. It is removed if it is given up.
class StoreBackup {
 public:
  static StoreResult<StoreBackup> begin(sqlite::Database& source, const std::filesystem::path& file);
  StoreBackup(StoreBackup&&) noexcept;
  StoreBackup& operator=(StoreBackup&&) = delete;
  ~StoreBackup();

  /// In the thread of the source. @return whether all is there
  StoreResult<bool> step();
  /// In any thread, once all is there: makes the file independent of its log, checks it, syncs it and renames
  /// it.
  /// @return its size in bytes
  StoreResult<std::uintmax_t> finish();

 private:
  struct End {
    void operator()(sqlite3_backup* backup) const;
  };
  StoreBackup(std::filesystem::path file, std::filesystem::path part);

  std::filesystem::path file_, part_;  ///< part_: empty once there is nothing to clean up
  std::unique_ptr<sqlite::Database> copy_;
  std::unique_ptr<sqlite3_backup, End> backup_;  ///< goes before the copy
};

/// Removes a database and the log files that SQLite keeps with it.
void remove_with_logs(const std::filesystem::path& database);

}  // namespace truepose::daemon
