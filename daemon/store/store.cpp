#include "daemon/store/store.hpp"

#include <string_view>
#include <utility>

#include "core/planted_bug.hpp"
#include "daemon/store/sqlite.hpp"
#include "daemon/store/store_impl.hpp"
#include "daemon/store/store_schema.hpp"

namespace truepose::daemon {
namespace {

using sqlite::Database;
using sqlite::in;
using sqlite::Statement;
using sqlite::Transaction;

StoreResult<void> prepare_connection(Database& database) {
  // FULL: a commit that returned survives a power cut, which NORMAL does not promise in WAL mode.
  const StoreResult<void> prepared = database.execute(
      "PRAGMA busy_timeout=2000; PRAGMA journal_mode=WAL; PRAGMA synchronous=FULL; PRAGMA foreign_keys=ON");
  if (planted("a commit is not synced")) return database.execute("PRAGMA synchronous=OFF");
  return prepared;
}

StoreResult<void> unharmed(Database& database, const std::string& file) {
  const StoreResult<std::string> check = database.value("PRAGMA quick_check(1)");
  if (!check) return std::unexpected(check.error());
  if (*check != "ok")
    return std::unexpected(StoreError{file + ": is damaged (" + *check + "); restore a backup"});
  return {};
}

/// One whose file is whole.
StoreResult<std::unique_ptr<Database>> open_checked(std::string_view operation, const std::string& file) {
  StoreResult<std::unique_ptr<Database>> database = Database::open(file);
  if (!database) return std::unexpected(in(operation, database.error()));
  StoreResult<void> good = prepare_connection(**database);
  if (good) good = unharmed(**database, file);
  if (!good) return std::unexpected(in(operation, good.error()));
  return database;
}

/// A migration cannot be undone: a copy of the older store is kept next to it.
StoreResult<void> keep_older(Database& database, const std::filesystem::path& file, SchemaSteps steps) {
  const StoreResult<std::size_t> version = known_version(database, file.string(), steps);
  if (!version) return std::unexpected(version.error());
  const std::filesystem::path kept = file.string() + ".schema-" + std::to_string(*version);
  if (*version == 0 || *version == steps.size() || std::filesystem::exists(kept)) return {};
  auto copy = StoreBackup::begin(database, kept);
  if (!copy) return std::unexpected(copy.error());
  for (StoreResult<bool> done = false; !*done;) {
    done = copy->step();
    if (!done) return std::unexpected(done.error());
  }
  const auto finished = copy->finish();
  if (!finished) return std::unexpected(finished.error());
  return {};
}

}  // namespace

StoreResult<void> Store::Impl::commit(std::string_view operation, const std::vector<Statement*>& statements) {
  return sqlite::commit(*database, operation, statements);
}

Store::Store(std::unique_ptr<Impl> impl) : impl_{std::move(impl)} {}
Store::Store(Store&&) noexcept = default;
Store& Store::operator=(Store&&) noexcept = default;
Store::~Store() = default;

StoreResult<Store> Store::open(const std::filesystem::path& file, SchemaSteps steps) {
  constexpr std::string_view kOperation = "opening the store";
  StoreResult<std::unique_ptr<Database>> database = open_checked(kOperation, file.string());
  if (!database) return std::unexpected(database.error());
  if (const StoreResult<void> kept = keep_older(**database, file, steps); !kept)
    return std::unexpected(in(kOperation, kept.error()));
  StoreResult<Transaction> transaction = Transaction::begin(**database);
  if (!transaction) return std::unexpected(in(kOperation, transaction.error()));
  StoreResult<void> migrated = migrate(**database, file.string(), steps);
  if (migrated) migrated = transaction->commit();
  if (!migrated) return std::unexpected(in(kOperation, migrated.error()));
  (*database)->watch_logs();
  return Store{std::make_unique<Impl>(Impl{file, std::move(*database)})};
}

StoreResult<Store> Store::open_to_read(const std::filesystem::path& file, SchemaSteps steps) {
  constexpr std::string_view kOperation = "reading the store";
  StoreResult<std::unique_ptr<Database>> database = Database::open_to_read(file.string());
  if (!database) return std::unexpected(in(kOperation, database.error()));
  const StoreResult<void> patient = (*database)->execute("PRAGMA busy_timeout=2000");
  if (!patient) return std::unexpected(in(kOperation, patient.error()));
  const StoreResult<std::size_t> version = known_version(**database, file.string(), steps);
  if (!version) return std::unexpected(in(kOperation, version.error()));
  if (*version == 0) return std::unexpected(in(kOperation, {file.string() + ": is empty"}));
  if (*version < steps.size()) {
    StoreResult<std::unique_ptr<Database>> copy = Database::copy_in_memory(**database);
    if (!copy) return std::unexpected(in(kOperation, copy.error()));
    database = *std::move(copy);
    const StoreResult<void> migrated = migrate(**database, file.string(), steps);
    if (!migrated) return std::unexpected(in(kOperation, migrated.error()));
  }
  return Store{std::make_unique<Impl>(Impl{file, *std::move(database)})};
}

StoreResult<void> Store::examine(const std::filesystem::path& file) {
  constexpr std::string_view kOperation = "examining the store";
  StoreResult<std::unique_ptr<Database>> database = Database::open_to_read(file.string());
  if (!database) return std::unexpected(in(kOperation, database.error()));
  const StoreResult<std::size_t> version = known_version(**database, file.string(), kSchemaSteps);
  if (!version) return std::unexpected(in(kOperation, version.error()));
  const StoreResult<void> check = unharmed(**database, file.string());
  if (!check) return std::unexpected(in(kOperation, check.error()));
  return {};
}

StoreResult<StoreBackup> Store::begin_backup(const std::filesystem::path& file) {
  return StoreBackup::begin(*impl_->database, file);
}

StoreResult<void> Store::begin_new_life(std::uint64_t beyond) {
  Statement disarm = impl_->database->prepare("DELETE FROM armed");
  Statement number = impl_->database->prepare("UPDATE event_number SET last=max(last, ?)");
  number.bind(static_cast<std::int64_t>(beyond));
  return impl_->commit("starting with a copy", {&disarm, &number});
}

StoreResult<std::uint64_t> Store::last_event_number() {
  Statement query = impl_->database->prepare("SELECT last FROM event_number");
  const StoreResult<bool> row = query.step();
  if (!row) return std::unexpected(row.error());
  return static_cast<std::uint64_t>(query.integer(0));
}

StoreResult<void> Store::in_place() {
  StoreResult<void> there = impl_->database->in_place();
  if (!there && impl_->database->lost_log() && !impl_->database->log_of_another()) impl_->gather();
  return there;
}

StoreResult<void> Store::try_again() {
  constexpr std::string_view kOperation = "trying the store again";
  const bool lost_log = impl_->database->lost_log();
  if (lost_log && impl_->database->log_of_another())
    return std::unexpected(
        StoreError{impl_->file.string() + "-wal: another program writes to the store; end it", true});
  if (const StoreResult<void> there = in_place(); !there && !lost_log) return there;
  if (impl_->database->device_error() || lost_log) {
    // The old connection goes only once there is another.
    StoreResult<std::unique_ptr<Database>> database = open_checked(kOperation, impl_->file.string());
    if (!database) return std::unexpected(database.error());
    impl_->database = *std::move(database);
  }
  // That what is in the log fits into the file, and that there is room for more.
  const StoreResult<std::string> gathered = impl_->database->value("PRAGMA wal_checkpoint(TRUNCATE)");
  if (!gathered) return std::unexpected(in(kOperation, gathered.error()));
  Statement write = impl_->database->prepare("UPDATE event_number SET last=last");
  StoreResult<void> written = impl_->commit(kOperation, {&write});
  if (written) impl_->database->watch_logs();
  return written;
}

StoreResult<void> Store::use_tool(int number, const std::string& campaign_id) {
  Statement remove = impl_->database->prepare("DELETE FROM tool WHERE number=?");
  remove.bind(std::int64_t{number});
  if (campaign_id.empty()) return impl_->commit("taking a tool out of use", {&remove});
  Statement use = impl_->database->prepare("INSERT INTO tool (number, campaign_id) VALUES (?,?)");
  use.bind(std::int64_t{number}).bind(campaign_id);
  return impl_->commit("taking a tool into use", {&remove, &use});
}

StoreResult<std::vector<ToolInUse>> Store::tools_in_use() {
  const auto tool_of = [](const Statement& row) {
    return ToolInUse{static_cast<int>(row.integer(0)), row.text(1)};
  };
  return all_records<ToolInUse>(
      impl_->database->prepare("SELECT number, campaign_id FROM tool ORDER BY number"), +tool_of);
}

StoreResult<void> Store::keep_audit_head(const control::AuditHead& head) {
  Statement keep = impl_->database->prepare("INSERT OR REPLACE INTO audit_head VALUES (?,?)");
  keep.bind(static_cast<std::int64_t>(head.count)).bind(head.hash);
  return impl_->commit("storing the end of the audit trail", {&keep});
}

StoreResult<std::vector<control::AuditHead>> Store::audit_heads() {
  const auto head_of = [](const Statement& row) {
    return control::AuditHead{static_cast<std::uint64_t>(row.integer(0)), row.text(1)};
  };
  return all_records<control::AuditHead>(
      impl_->database->prepare("SELECT count, sha256 FROM audit_head ORDER BY count"), +head_of);
}

StoreResult<void> Store::keep_armed(const std::string& since) {
  Statement disarm = impl_->database->prepare("DELETE FROM armed");
  if (since.empty()) return impl_->commit("disarming the stream", {&disarm});
  Statement arm = impl_->database->prepare("INSERT INTO armed VALUES (1, ?)");
  arm.bind(since);
  return impl_->commit("arming the stream", {&disarm, &arm});
}

StoreResult<std::string> Store::armed_since() {
  Statement query = impl_->database->prepare("SELECT since FROM armed");
  const StoreResult<bool> row = query.step();
  if (!row) return std::unexpected(row.error());
  return *row ? query.text(0) : std::string{};
}

}  // namespace truepose::daemon
