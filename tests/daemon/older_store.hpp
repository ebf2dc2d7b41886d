#pragma once

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "tests/integration/sqlite_rows.hpp"

namespace truepose {

/// Makes a store's file what it was when the schema had this version, 2 to 13.
inline void make_older(const std::filesystem::path& file, int version) {
  static const std::vector<std::pair<int, std::vector<const char*>>> kAdded{
      {14, {"ALTER TABLE point DROP COLUMN orientation"}},
      {13, {"DROP TABLE audit_head"}},
      {12, {"ALTER TABLE campaign DROP COLUMN document_sha256"}},
      {11,
       {R"sql(CREATE TABLE old_point (number INTEGER PRIMARY KEY, campaign_id TEXT NOT NULL REFERENCES campaign (id),
          pose INTEGER NOT NULL, purpose TEXT NOT NULL, q_target TEXT NOT NULL, q_commanded TEXT NOT NULL,
          q_actual TEXT NOT NULL, direction TEXT NOT NULL, smr TEXT NOT NULL, x_mm REAL NOT NULL, y_mm REAL NOT NULL,
          z_mm REAL NOT NULL, std_x_mm REAL NOT NULL, std_y_mm REAL NOT NULL, std_z_mm REAL NOT NULL,
          temperature_c REAL NOT NULL, pressure_mbar REAL NOT NULL, humidity_percent REAL NOT NULL,
          time TEXT NOT NULL, resumption INTEGER NOT NULL DEFAULT 0) STRICT)sql",
        "INSERT INTO old_point SELECT * FROM point", "DROP TABLE point",
        "ALTER TABLE old_point RENAME TO point", "CREATE INDEX point_of_campaign ON point (campaign_id)"}},
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
