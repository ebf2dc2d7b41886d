#pragma once

#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "daemon/store/sqlite.hpp"
#include "daemon/store/store.hpp"

namespace truepose::daemon {

/// What the sources of the store share.
struct Store::Impl {
  std::filesystem::path file;
  std::unique_ptr<sqlite::Database> database;

  sqlite::Statement inserted(const ModelRecord& model);
  sqlite::Statement activated(const std::string& id);
  sqlite::Statement none_active();
  StoreResult<std::optional<CampaignRecord>> one_campaign(sqlite::Statement query);
  /// Says whose points a campaign is of.
  StoreResult<void> name_source(CampaignRecord& record);
  StoreResult<std::vector<StoredPoint>> measured(const std::string& campaign_id);

  /// Brings what is committed from the log into the file itself, so that the file alone is the whole store.
  /// If another connection reads at that moment, it is left to the next time: it is on the disk either way.
  void gather() { static_cast<void>(database->value("PRAGMA wal_checkpoint(TRUNCATE)")); }

  /// Runs statements as one transaction: on the disk, or not at all.
  StoreResult<void> commit(std::string_view operation, const std::vector<sqlite::Statement*>& statements);
};

/// What the rows of a query are.
template <typename Record>
StoreResult<std::vector<Record>> all_records(sqlite::Statement query,
                                             Record (*of)(const sqlite::Statement&)) {
  std::vector<Record> records;
  for (;;) {
    const StoreResult<bool> row = query.step();
    if (!row) return std::unexpected(row.error());
    if (!*row) return records;
    records.push_back(of(query));
  }
}

/// Of its first row; nothing of a query without rows.
template <typename Record>
StoreResult<std::optional<Record>> first_record(sqlite::Statement query,
                                                Record (*of)(const sqlite::Statement&)) {
  const StoreResult<bool> row = query.step();
  if (!row) return std::unexpected(row.error());
  if (!*row) return std::nullopt;
  return of(query);
}

}  // namespace truepose::daemon
