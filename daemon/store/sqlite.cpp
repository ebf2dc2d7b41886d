#include "daemon/store/sqlite.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <filesystem>
#include <system_error>

#include "core/formatted.hpp"
#include "proto/text/device_text.hpp"

namespace truepose::daemon::sqlite {

namespace {

/// A write that found no room has changed nothing, however SQLite calls it: that of the index of the log, or
/// one beyond a quota. A sync that did is another matter: it is unknown what is on the disk then.
bool is_full(int code, sqlite3* connection) {
  if ((code & 0xff) == SQLITE_FULL) return true;
  const bool wrote = code == SQLITE_IOERR_WRITE || code == SQLITE_IOERR_SHMSIZE;
  const int reason = connection == nullptr ? 0 : sqlite3_system_errno(connection);
  return wrote && (reason == ENOSPC || reason == EDQUOT || reason == EFBIG);
}

}  // namespace

void Statement::bound(int code) {
  if (!error_ && code != SQLITE_OK) error_ = database_->error(code);
}

Statement& Statement::bind(std::string_view text) {
  bound(sqlite3_bind_text64(statement_.get(), next_++, text.data() == nullptr ? "" : text.data(), text.size(),
                            SQLITE_TRANSIENT, SQLITE_UTF8));
  return *this;
}

Statement& Statement::bind(double number) {
  bound(sqlite3_bind_double(statement_.get(), next_++, number));
  return *this;
}

Statement& Statement::bind(std::int64_t number) {
  bound(sqlite3_bind_int64(statement_.get(), next_++, number));
  return *this;
}

Statement& Statement::bind(const std::optional<double>& number) {
  if (number) return bind(*number);
  bound(sqlite3_bind_null(statement_.get(), next_++));
  return *this;
}

StoreResult<bool> Statement::step() {
  if (error_) return std::unexpected(*error_);
  const int code = sqlite3_step(statement_.get());
  if (code == SQLITE_ROW) return true;
  if (code == SQLITE_DONE) return false;
  return std::unexpected(database_->error(code));
}

StoreResult<void> Statement::run() {
  for (;;) {
    const StoreResult<bool> row = step();
    if (!row) return std::unexpected(row.error());
    if (!*row) return {};
  }
}

std::string_view Statement::bytes(int column) const {
  const unsigned char* const bytes = sqlite3_column_text(statement_.get(), column);
  if (bytes == nullptr) return {};
  return {reinterpret_cast<const char*>(bytes),
          static_cast<std::size_t>(sqlite3_column_bytes(statement_.get(), column))};
}

std::string Statement::text(int column) const {
  return text::clean_text(bytes(column), text::LineBreaks::Blank);
}

std::string Statement::document(int column) const {
  return text::clean_text(bytes(column), text::LineBreaks::Kept);
}

StoreResult<std::unique_ptr<Database>> Database::open(const std::string& file) {
  // SQLite would make it readable for everybody. Its other files take the rights of this one.
  const int made = ::open(file.c_str(), O_RDWR | O_CREAT | O_EXCL | O_CLOEXEC, S_IRUSR | S_IWUSR);
  if (made >= 0) ::close(made);
  // Under each name it would have a log of its own.
  struct stat found {};
  if (::stat(file.c_str(), &found) == 0 && S_ISREG(found.st_mode) && found.st_nlink > 1)
    return std::unexpected(
        StoreError{file + ": the file has " + std::to_string(found.st_nlink) +
                   " names (hard links), and each would have a log of its own; remove all but one: "
                   "find " +
                   std::filesystem::path{file}.parent_path().string() + " -samefile " + file});
  auto database = open(file, SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE);
  if (database) (*database)->opened_ = identity_of(file);
  // One of before may be open to all.
  if (database && (found.st_mode & S_IRWXO) != 0)
    static_cast<void>(::chmod(file.c_str(), found.st_mode & 07770));
  return database;
}

Database::Identity Database::identity_of(const std::string& file) {
  struct stat found {};
  if (::stat(file.c_str(), &found) != 0) return std::nullopt;
  return std::pair{found.st_dev, found.st_ino};
}

void Database::watch_logs() {
  for (std::size_t i = 0; i < kLogs.size(); ++i) opened_logs_[i] = identity_of(file_ + kLogs[i]);
}

bool Database::lost_log() const { return opened_ == identity_of(file_) && !in_place(); }

bool Database::log_of_another() const {
  std::error_code none;
  const auto size = std::filesystem::file_size(file_ + kLogs[0], none);
  return opened_logs_[0] != identity_of(file_ + kLogs[0]) && !none && size > 0;
}

StoreResult<void> Database::in_place() const {
  if (!opened_) return {};
  for (std::size_t i = 0; opened_ == identity_of(file_) && i < kLogs.size(); ++i) {
    const std::string log = file_ + kLogs[i];
    if (opened_logs_[i] && opened_logs_[i] != identity_of(log))
      return std::unexpected(StoreError{
          log +
              ": was deleted, moved away or replaced while the daemon has it open; what was stored is in the store, "
              "and the file is made again",
          true});
  }
  if (opened_ == identity_of(file_)) return {};
  return std::unexpected(StoreError{
      file_ +
          ": is another file than the daemon opened: that was deleted, moved away or replaced. Put it back, or "
          "save what the daemon still reads of it (truepose backup) and restart the daemon with what is there",
      true});
}

StoreResult<std::unique_ptr<Database>> Database::open_to_read(const std::string& file) {
  std::error_code none;
  if (std::filesystem::status(file, none).type() == std::filesystem::file_type::not_found)
    return std::unexpected(StoreError{file + ": there is no such file"});
  if (std::filesystem::exists(file + "-wal", none)) return open(file, SQLITE_OPEN_READONLY);
  // No process has it open. SQLite would make a log to read it by, and could not where it may not write.
  std::string uri = "file:";
  for (const char letter : file) {
    constexpr std::string_view kSpecial = "%?#";
    uri += kSpecial.contains(letter) ? formatted("%%%02x", letter) : std::string{letter};
  }
  return open(file, SQLITE_OPEN_READONLY | SQLITE_OPEN_URI, uri + "?immutable=1");
}

StoreResult<std::unique_ptr<Database>> Database::copy_in_memory(Database& source) {
  auto copy = open(source.file_, SQLITE_OPEN_READWRITE | SQLITE_OPEN_MEMORY, ":memory:");
  if (!copy) return copy;
  sqlite3_backup* const backup =
      sqlite3_backup_init((*copy)->connection(), "main", source.connection(), "main");
  if (backup != nullptr) sqlite3_backup_step(backup, -1);
  const int code = backup != nullptr ? sqlite3_backup_finish(backup) : sqlite3_errcode((*copy)->connection());
  if (code != SQLITE_OK) return std::unexpected((*copy)->error(code));
  return copy;
}

StoreResult<std::unique_ptr<Database>> Database::open(const std::string& file, int flags,
                                                      const std::string& uri) {
  sqlite3* connection = nullptr;
  const int code = sqlite3_open_v2(uri.empty() ? file.c_str() : uri.c_str(), &connection, flags, nullptr);
  std::unique_ptr<Database> database{new Database{file, connection}};
  if (code != SQLITE_OK) return std::unexpected(database->error(code));
  sqlite3_extended_result_codes(connection, 1);
  return database;
}

Statement Database::prepare(std::string_view sql) {
  sqlite3_stmt* statement = nullptr;
  const int code =
      sqlite3_prepare_v2(connection_.get(), sql.data(), static_cast<int>(sql.size()), &statement, nullptr);
  // At once: the words of an error are those of the last call.
  return Statement{*this, statement, code == SQLITE_OK ? std::nullopt : std::optional{error(code)}};
}

StoreResult<void> Database::execute(const std::string& sql) {
  const int code = sqlite3_exec(connection_.get(), sql.c_str(), nullptr, nullptr, nullptr);
  if (code != SQLITE_OK) return std::unexpected(error(code));
  return {};
}

StoreResult<std::string> Database::value(std::string_view sql) {
  Statement query = prepare(sql);
  const StoreResult<bool> row = query.step();
  if (!row) return std::unexpected(row.error());
  return *row ? query.text(0) : std::string{};
}

namespace {

/// What to do about a file that fails in this way.
std::string_view repair_of(int kind) {
  switch (kind) {
    case SQLITE_BUSY:
    case SQLITE_LOCKED:
      return "; end the other program that writes to it";
    case SQLITE_READONLY:
    case SQLITE_PERM:
    case SQLITE_CANTOPEN:
      return "; look at the owner and the rights of the file";
    case SQLITE_IOERR:
    case SQLITE_CORRUPT:
    case SQLITE_NOTADB:
      return "; check the disk";
    default:
      return "";
  }
}

}  // namespace

StoreError Database::error(int code) {
  const char* const says = connection_ ? sqlite3_errmsg(connection_.get()) : sqlite3_errstr(code);
  const bool full = is_full(code, connection_.get());
  const int kind = code & 0xff;
  const bool may_pass =
      kind == SQLITE_BUSY || kind == SQLITE_LOCKED || kind == SQLITE_IOERR || kind == SQLITE_NOMEM;
  StoreError error{file_ + ": " + text::clean_text(says, text::LineBreaks::Blank), full || may_pass};
  if (kind == SQLITE_IOERR && !full && !device_error_) device_error_ = error;
  error.detail += full ? "; make room on the disk" : repair_of(kind);
  return error;
}

StoreResult<Transaction> Transaction::begin(Database& database) {
  if (const auto& failed = database.device_error()) {
    return std::unexpected(StoreError{failed->detail + " (earlier); check the disk", true});
  }
  if (const StoreResult<void> there = database.in_place(); !there) return std::unexpected(there.error());
  // IMMEDIATE: another writer is detected here, not in the middle.
  const StoreResult<void> begun = database.execute("BEGIN IMMEDIATE");
  if (!begun) return std::unexpected(begun.error());
  return Transaction{database};
}

Transaction::~Transaction() {
  // Where SQLite itself rolled back (disk full), there is nothing left to roll back, and that error says so.
  if (database_ != nullptr) static_cast<void>(database_->execute("ROLLBACK"));
}

StoreResult<void> Transaction::commit() {
  StoreResult<void> committed = database_->execute("COMMIT");
  if (committed) database_ = nullptr;
  return committed;
}

StoreError in(std::string_view operation, const StoreError& error) {
  return {std::string{operation} + ": " + error.detail, error.may_pass};
}

StoreResult<void> commit(Database& database, std::string_view operation,
                         const std::vector<Statement*>& statements) {
  StoreResult<Transaction> transaction = Transaction::begin(database);
  if (!transaction) return std::unexpected(in(operation, transaction.error()));
  StoreResult<void> result;
  for (std::size_t i = 0; result && i < statements.size(); ++i) result = statements[i]->run();
  if (result) result = transaction->commit();
  if (!result) return std::unexpected(in(operation, result.error()));
  return {};
}

}  // namespace truepose::daemon::sqlite
