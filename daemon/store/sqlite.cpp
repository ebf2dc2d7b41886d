#include "daemon/store/sqlite.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include "proto/text/device_text.hpp"

namespace truepose::daemon::sqlite {

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
  return open(file, SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE);
}

StoreResult<std::unique_ptr<Database>> Database::open_to_read(const std::string& file) {
  return open(file, SQLITE_OPEN_READONLY);
}

StoreResult<std::unique_ptr<Database>> Database::open(const std::string& file, int flags) {
  sqlite3* connection = nullptr;
  const int code = sqlite3_open_v2(file.c_str(), &connection, flags, nullptr);
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

StoreError Database::error(int code) {
  const char* const says = connection_ ? sqlite3_errmsg(connection_.get()) : sqlite3_errstr(code);
  const int kind = code & 0xff;
  StoreError error{file_ + ": " + says, kind == SQLITE_FULL || kind == SQLITE_BUSY || kind == SQLITE_LOCKED};
  if (kind == SQLITE_FULL) error.detail += "; free space, then restart";
  if (kind == SQLITE_IOERR && !device_error_) device_error_ = error;
  return error;
}

StoreResult<Transaction> Transaction::begin(Database& database) {
  if (const auto& failed = database.device_error()) {
    return std::unexpected(StoreError{failed->detail + " (earlier); check the disk, then restart"});
  }
  // IMMEDIATE: whoever else writes is found out here, not in the middle.
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
