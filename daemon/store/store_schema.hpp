#pragma once

#include <cstddef>
#include <span>
#include <string>

#include "daemon/store/store_error.hpp"

namespace truepose::daemon {
namespace sqlite {
class Database;
}

/// SQL that brings a store from each version of the schema to the next, the first from an empty database.
/// A change of the tables appends a step. A step that stores were written with is not changed.
using SchemaSteps = std::span<const char* const>;
extern const SchemaSteps kSchemaSteps;

/// The version of the schema, 0 of a database without tables.
/// Error: not a database of ours, or a version beyond these steps.
StoreResult<std::size_t> known_version(sqlite::Database& database, const std::string& file,
                                       SchemaSteps steps);

/// Makes the tables, or executes the steps that an older version lacks; within the caller's transaction.
/// Errors: as known_version().
StoreResult<void> migrate(sqlite::Database& database, const std::string& file, SchemaSteps steps);

}  // namespace truepose::daemon
