#pragma once

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "tests/integration/sqlite_rows.hpp"

namespace truepose {

/// Makes a store's file what it was when the schema had this version, 2 to 9.
inline void make_older(const std::filesystem::path& file, int version) {
  static const std::vector<std::pair<int, std::vector<const char*>>> kAdded{
      {10, {"DROP TABLE tool"}},
      {9,
       {"DROP TABLE planned", "DROP TABLE plan", "DROP TABLE resumption",
        "ALTER TABLE point DROP COLUMN resumption"}},
      {8,
       {"DROP TABLE event", "DROP TABLE event_gap", "DROP TABLE identification",
        "ALTER TABLE event_number DROP COLUMN kept"}},
      {7,
       {"DROP TRIGGER model_activated", "DROP TABLE activation",
        "ALTER TABLE campaign DROP COLUMN started_by", "ALTER TABLE campaign DROP COLUMN note"}},
      {5, {"DROP TABLE armed"}},
      {4, {"ALTER TABLE model DROP COLUMN sha256", "ALTER TABLE model DROP COLUMN largest_correction_deg"}}};
  for (const auto& [added, undo] : kAdded)
    for (const char* const sql : undo)
      if (version < added) sqlite_rows(file, sql);
  sqlite_rows(file, ("PRAGMA user_version=" + std::to_string(version)).c_str());
}

}  // namespace truepose
