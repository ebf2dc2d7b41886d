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

/// A copy of a store in the making, some pages at a time, so that what is to be stored meanwhile waits for no
/// more than one step, and is in the copy. Its file is for its owner alone, and lies beside its place under
/// another name until it is whole and on the disk; it goes away if it is given up.
class StoreBackup {
 public:
  static StoreResult<StoreBackup> begin(sqlite::Database& source, const std::filesystem::path& file);
  StoreBackup(StoreBackup&&) noexcept;
  StoreBackup& operator=(StoreBackup&&) = delete;
  ~StoreBackup();

  /// In the thread of the source. @return whether all is there
  StoreResult<bool> step();
  /// In any thread, once all is there: makes the file one that needs no other beside it, checks it, puts it
  /// on the disk and lets it take its place.
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

/// Where the parts of a store that is copied to, or from, lie: what SQLite keeps beside a file.
void remove_with_logs(const std::filesystem::path& database);

}  // namespace truepose::daemon
