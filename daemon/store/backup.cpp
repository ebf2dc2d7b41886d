#include "daemon/store/backup.hpp"

#include <cerrno>
#include <cstring>
#include <system_error>
#include <utility>

#include "config/text_file.hpp"
#include "daemon/store/sqlite.hpp"
#include "daemon/store/store_impl.hpp"

namespace truepose::daemon {

namespace fs = std::filesystem;
using sqlite::Database;
using sqlite::in;

namespace {

constexpr int kPagesAtATime = 256;  // a megabyte: some milliseconds
constexpr const char* kBackup = "backup";

StoreError of_system(const fs::path& file, int error) {
  const bool full = error == ENOSPC || error == EDQUOT;
  return {std::string{kBackup} + ": " + file.string() + ": " + std::strerror(error), full};
}

}  // namespace

void remove_with_logs(const fs::path& database) {
  std::error_code none;
  for (const char* suffix : {"", "-wal", "-shm", "-journal"}) fs::remove(database.string() + suffix, none);
}

void StoreBackup::End::operator()(sqlite3_backup* backup) const { sqlite3_backup_finish(backup); }

StoreBackup::StoreBackup(fs::path file, fs::path part) : file_{std::move(file)}, part_{std::move(part)} {}

StoreBackup::StoreBackup(StoreBackup&& other) noexcept
    : file_{std::move(other.file_)},
      part_{std::exchange(other.part_, {})},
      copy_{std::move(other.copy_)},
      backup_{std::move(other.backup_)} {}

StoreBackup::~StoreBackup() {
  backup_.reset();
  copy_.reset();
  if (!part_.empty()) remove_with_logs(part_);
}

StoreResult<StoreBackup> StoreBackup::begin(Database& source, const fs::path& file) {
  StoreBackup backup{file, file.string() + ".part"};
  remove_with_logs(backup.part_);  // of one that died
  StoreResult<std::unique_ptr<Database>> copy = Database::open(backup.part_.string());
  if (!copy) return std::unexpected(in(kBackup, copy.error()));
  backup.copy_ = *std::move(copy);
  // All is synced at the end.
  const StoreResult<void> prepared = backup.copy_->execute("PRAGMA synchronous=OFF; PRAGMA journal_mode=OFF");
  if (!prepared) return std::unexpected(in(kBackup, prepared.error()));
  sqlite3* const to = backup.copy_->connection();
  backup.backup_.reset(sqlite3_backup_init(to, "main", source.connection(), "main"));
  if (!backup.backup_) return std::unexpected(in(kBackup, backup.copy_->error(sqlite3_errcode(to))));
  return backup;
}

StoreResult<bool> StoreBackup::step() {
  const int code = sqlite3_backup_step(backup_.get(), kPagesAtATime);
  if (code == SQLITE_DONE) return true;
  // Another connection writes or reads at this moment.
  if (code == SQLITE_OK || code == SQLITE_BUSY || code == SQLITE_LOCKED) return false;
  return std::unexpected(
      StoreError{std::string{kBackup} + ": " + part_.string() + ": " + sqlite3_errstr(code),
                 (code & 0xff) == SQLITE_FULL});
}

StoreResult<std::uintmax_t> StoreBackup::finish() {
  backup_.reset();
  // The copy says, as its source does, that it has a log file.
  StoreResult<std::string> alone = copy_->value("PRAGMA journal_mode=DELETE");
  if (!alone) return std::unexpected(in(kBackup, alone.error()));
  const StoreResult<std::string> check = copy_->value("PRAGMA quick_check(1)");
  if (!check) return std::unexpected(in(kBackup, check.error()));
  if (*check != "ok")
    return std::unexpected(StoreError{std::string{kBackup} + ": the copy is damaged (" + *check + ")"});
  copy_.reset();
  std::error_code failed;
  const std::uintmax_t bytes = fs::file_size(part_, failed);
  if (!config::synced(part_)) return std::unexpected(of_system(part_, errno));
  fs::rename(part_, file_, failed);
  if (failed) return std::unexpected(of_system(file_, failed.value()));
  part_.clear();
  if (!config::synced(config::folder_of(file_))) return std::unexpected(of_system(file_, errno));
  return bytes;
}

}  // namespace truepose::daemon
