#include "daemon/store/restore.hpp"

#include <fcntl.h>

#include <cerrno>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <memory>
#include <optional>
#include <system_error>

#include "config/text_file.hpp"
#include "daemon/store/as_owner.hpp"
#include "daemon/store/backup.hpp"
#include "daemon/store/runtime_folder.hpp"
#include "daemon/store/sqlite.hpp"
#include "daemon/store/store.hpp"

namespace truepose::daemon {

namespace fs = std::filesystem;

namespace {

using Restored = std::expected<void, std::string>;

/// Numbers of events that a store which cannot be read may have given beyond those of its backup.
constexpr std::uint64_t kMoreThanEver = 1'000'000'000;

std::unexpected<std::string> system_failure(const fs::path& file, int error) {
  return std::unexpected(file.string() + ": " + std::strerror(error));
}

/// A backup, read with the caller's own rights.
std::expected<std::unique_ptr<sqlite::Database>, std::string> read_backup(const fs::path& backup) {
  if (const StoreResult<void> good = Store::examine(backup); !good)
    return std::unexpected(good.error().detail);
  auto source = sqlite::Database::open_to_read(backup.string());
  if (!source) return std::unexpected(source.error().detail);
  auto read = sqlite::Database::copy_in_memory(**source);
  if (!read) return std::unexpected(read.error().detail);
  return *std::move(read);
}

/// A copy of a store at a place.
Restored copy_to(const fs::path& place, sqlite::Database& source) {
  auto copy = StoreBackup::begin(source, place);
  if (!copy) return std::unexpected(copy.error().detail);
  for (StoreResult<bool> done = false; !done.value();) {
    done = copy->step();
    if (!done) return std::unexpected(done.error().detail);
  }
  const auto finished = copy->finish();
  if (!finished) return std::unexpected(finished.error().detail);
  return {};
}

/// Migrates a copy. It has no log files then.
Restored make_ready(const fs::path& copy, std::optional<std::uint64_t> last_number) {
  StoreResult<Store> store = Store::open(copy);
  if (!store) return std::unexpected(store.error().detail);
  const StoreResult<std::uint64_t> own = store->last_event_number();
  if (!own) return std::unexpected(own.error().detail);
  const auto begun = store->begin_new_life(last_number.value_or(*own + kMoreThanEver));
  if (!begun) return std::unexpected(begun.error().detail);
  return {};
}

/// Brings all of the store into its one file.
/// @return the last number of its events; nothing where it cannot be read
std::optional<std::uint64_t> gather(const fs::path& store) {
  // One that is no store would lose its log by being opened.
  if (!Store::examine(store)) return std::nullopt;
  StoreResult<Store> old = Store::open(store);
  if (!old) return std::nullopt;
  const auto last = old->last_event_number();
  return last ? std::optional{*last} : std::nullopt;
}

/// Puts a copy in the place of a store. Neither has two names meanwhile, as a hard link would have: such a
/// store is not opened.
/// @return the new name of the store; empty: there was none
std::expected<fs::path, std::string> take_place(const fs::path& copy, const fs::path& store,
                                                const std::string& time) {
  std::error_code error;
  if (!fs::exists(store, error)) {
    fs::rename(copy, store, error);
    return error ? std::expected<fs::path, std::string>{system_failure(store, error.value())} : fs::path{};
  }
  const fs::path aside = store.string() + ".before-" + time;
  // Only a store that could not be read still has log files.
  for (const char* log : {"-wal", "-shm"}) {
    fs::rename(store.string() + log, aside.string() + log, error);
    if (error && error != std::errc::no_such_file_or_directory) return system_failure(store, error.value());
  }
  if (::renameat2(AT_FDCWD, copy.c_str(), AT_FDCWD, store.c_str(), RENAME_EXCHANGE) != 0) {
    const auto failed = system_failure(store, errno);
    remove_with_logs(copy);
    return failed;
  }
  fs::rename(copy, aside, error);
  if (error) return system_failure(aside, error.value());
  return aside;
}

}  // namespace

std::expected<fs::path, std::string> restore_store(const fs::path& backup, const fs::path& store,
                                                   const std::string& time) {
  const auto source = read_backup(backup);
  if (!source) return std::unexpected(source.error());
  const auto owner = AsOwnerOf::take(config::folder_of(store));
  if (!owner) return std::unexpected(owner.error());
  const auto lock = LockFile::take(lock_of_store(store), "the store " + store.string());
  if (!lock) return std::unexpected(lock.error().text + "; stop the daemon first");

  const fs::path copy = store.string() + ".restored";
  Restored done = copy_to(copy, **source);
  std::error_code none;
  std::optional<std::uint64_t> last = 0;
  if (fs::exists(store, none)) last = gather(store);
  if (done) done = make_ready(copy, last);
  if (done && !config::synced(copy)) done = system_failure(copy, errno);
  if (!done) {
    remove_with_logs(copy);
    return std::unexpected(done.error());
  }
  const auto aside = take_place(copy, store, time);
  if (!aside) return aside;
  if (!config::synced(config::folder_of(store))) return system_failure(store, errno);
  return aside;
}

}  // namespace truepose::daemon
