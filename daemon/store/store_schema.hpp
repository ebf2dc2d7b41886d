#pragma once

#include <cstdint>
#include <string>

#include "daemon/store/sqlite.hpp"

namespace truepose::daemon {

/// Of the tables that this program reads and writes.
inline constexpr std::int64_t kSchemaVersion = 14;

/// The version of the schema, 0 of a database in which nothing is yet. Error: not a database of ours, or of a
/// newer truepose.
StoreResult<int> known_version(sqlite::Database& database, const std::string& file);

/// Makes the tables, or brings those of an older version up to date; within the caller's transaction. Errors:
/// as known_version().
StoreResult<void> migrate(sqlite::Database& database, const std::string& file);

}  // namespace truepose::daemon
