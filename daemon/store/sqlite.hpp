#pragma once

#include <sqlite3.h>
#include <sys/types.h>

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "daemon/store/store.hpp"

namespace truepose::daemon::sqlite {

class Database;

/// A prepared statement with its values bound. Values are bound in the order of their question marks.
class Statement {
 public:
  Statement& bind(std::string_view text);
  Statement& bind(double number);
  Statement& bind(std::int64_t number);
  /// NULL where there is none.
  Statement& bind(const std::optional<double>& number);

  /// @return true where there is a row, false at the end
  StoreResult<bool> step();
  /// Steps to the end, rows not regarded.
  StoreResult<void> run();

  /// Columns of the row, counted from 0.
  /// One line, fit to be logged and sent, whatever has become of the file.
  std::string text(int column) const;
  /// The same with the ends of its lines.
  std::string document(int column) const;
  bool is_null(int column) const { return sqlite3_column_type(statement_.get(), column) == SQLITE_NULL; }
  double number(int column) const { return sqlite3_column_double(statement_.get(), column); }
  std::int64_t integer(int column) const { return sqlite3_column_int64(statement_.get(), column); }

 private:
  friend class Database;
  struct Finalize {
    void operator()(sqlite3_stmt* statement) const { sqlite3_finalize(statement); }
  };
  Statement(Database& database, sqlite3_stmt* statement, std::optional<StoreError> error)
      : database_{&database}, statement_{statement}, error_{std::move(error)} {}
  void bound(int code);
  std::string_view bytes(int column) const;

  Database* database_;
  std::unique_ptr<sqlite3_stmt, Finalize> statement_;
  std::optional<StoreError>
      error_;  // first one of preparing or binding, in SQLite's words; reported by step()
  int next_ = 1;
};

/// One connection. Not thread-safe.
class Database {
 public:
  /// @param file  made where it does not exist, for its owner alone
  static StoreResult<std::unique_ptr<Database>> open(const std::string& file);
  /// Changes nothing, and creates no further file.
  static StoreResult<std::unique_ptr<Database>> open_to_read(const std::string& file);
  /// All of another, to be changed.
  static StoreResult<std::unique_ptr<Database>> copy_in_memory(Database& source);
  Database(const Database&) = delete;
  Database& operator=(const Database&) = delete;

  /// The statement's first step reports an error in the text.
  Statement prepare(std::string_view sql);
  /// Runs one or more statements without values.
  StoreResult<void> execute(const std::string& sql);
  /// The first column of the first row of a query, as text.
  StoreResult<std::string> value(std::string_view sql);
  int changes() const { return sqlite3_changes(connection_.get()); }
  sqlite3* connection() const { return connection_.get(); }

  /// "cell.db: database or disk is full; make room on the disk": the file, what SQLite says and what to do.
  /// Remembers errors of the device.
  StoreError error(int code);
  /// Once there are the log and its index, which SQLite makes next to the file.
  void watch_logs();
  /// Whether the file that was opened to be written and its logs are still those at their paths: not deleted,
  /// moved away or replaced.
  StoreResult<void> in_place() const;
  /// Whether the file is in its place, and a log is not.
  bool lost_log() const;
  /// Whether another program has written to a log in place of the lost one.
  bool log_of_another() const;
  /// The error of the device that this connection met first.
  const std::optional<StoreError>& device_error() const { return device_error_; }

 private:
  struct Close {
    void operator()(sqlite3* connection) const { sqlite3_close_v2(connection); }
  };
  using Identity = std::optional<std::pair<dev_t, ino_t>>;  ///< device and inode; none: there is no file
  static Identity identity_of(const std::string& file);
  static constexpr std::array<const char*, 2> kLogs{"-wal", "-shm"};
  static StoreResult<std::unique_ptr<Database>> open(const std::string& file, int flags,
                                                     const std::string& uri = {});
  Database(std::string file, sqlite3* connection) : file_{std::move(file)}, connection_{connection} {}

  std::string file_;
  Identity opened_;                                 // none: not to be written
  std::array<Identity, kLogs.size()> opened_logs_;  // none: not watched
  std::unique_ptr<sqlite3, Close> connection_;
  std::optional<StoreError> device_error_;
};

/// One write transaction: rolled back at its end unless committed.
class Transaction {
 public:
  /// Refused after an error of the device, and where the file is no longer in its place.
  static StoreResult<Transaction> begin(Database& database);
  Transaction(Transaction&& other) noexcept : database_{std::exchange(other.database_, nullptr)} {}
  Transaction& operator=(Transaction&&) = delete;
  ~Transaction();

  /// On the disk when this returns without an error.
  StoreResult<void> commit();

 private:
  explicit Transaction(Database& database) : database_{&database} {}
  Database* database_;  // nullptr once it is over
};

/// The error, with the operation that failed.
StoreError in(std::string_view operation, const StoreError& error);

/// Runs statements as one transaction: on the disk, or not at all. An error says which operation failed.
StoreResult<void> commit(Database& database, std::string_view operation,
                         const std::vector<Statement*>& statements);

}  // namespace truepose::daemon::sqlite
