#include "daemon/store/store_schema.hpp"

#include <array>
#include <cstdint>

#include "daemon/store/sqlite.hpp"

namespace truepose::daemon {
namespace {

constexpr std::int64_t kApplicationId = 0x54505345;  // "TPSE", shown by `file`

// Lists, matrices and documents are JSON. `kind`, `purpose` and `state` are the names of CampaignRecord and
// PointPurpose.
constexpr const char* kVersion1 = R"sql(
CREATE TABLE campaign (
  id              TEXT PRIMARY KEY,
  kind            TEXT NOT NULL CHECK (kind IN ('calibration', 'drift', 'targets', 'iso9283', 'tool', 'base')),
  started         TEXT NOT NULL,
  ended           TEXT NOT NULL,
  state           TEXT NOT NULL CHECK (state IN ('running', 'done', 'aborted', 'failed', 'interrupted')),
  reason          TEXT NOT NULL,
  started_by      TEXT NOT NULL,
  note            TEXT NOT NULL,
  robot_model     TEXT NOT NULL,
  robot_serial    TEXT NOT NULL,
  tracker_model   TEXT NOT NULL,
  tracker_serial  TEXT NOT NULL,
  model_id        TEXT NOT NULL,
  document        TEXT NOT NULL,
  document_sha256 TEXT NOT NULL DEFAULT ''
) STRICT;

-- A point that the TCP touched has no reading. `orientation`: R_WT row by row, then its standard deviation (rad).
CREATE TABLE point (
  number           INTEGER PRIMARY KEY,
  campaign_id      TEXT NOT NULL REFERENCES campaign (id),
  pose             INTEGER NOT NULL,
  purpose          TEXT NOT NULL CHECK (purpose IN
    ('identify', 'validate', 'remeasure', 'reference', 'target', 'cycle', 'nest', 'face1', 'check', 'frame')),
  q_target         TEXT NOT NULL CHECK (json_valid(q_target)),
  q_commanded      TEXT NOT NULL CHECK (json_valid(q_commanded)),
  q_actual         TEXT NOT NULL CHECK (json_valid(q_actual)),
  direction        TEXT NOT NULL CHECK (json_valid(direction)),
  smr              TEXT NOT NULL,
  x_mm             REAL CHECK (x_mm IS NOT NULL OR purpose = 'frame'),
  y_mm             REAL CHECK ((y_mm IS NULL) = (x_mm IS NULL)),
  z_mm             REAL CHECK ((z_mm IS NULL) = (x_mm IS NULL)),
  std_x_mm         REAL,
  std_y_mm         REAL,
  std_z_mm         REAL,
  temperature_c    REAL,
  pressure_mbar    REAL,
  humidity_percent REAL,
  time             TEXT NOT NULL,
  resumption       INTEGER NOT NULL DEFAULT 0,
  orientation      TEXT CHECK (orientation IS NULL OR json_valid(orientation))
) STRICT;
CREATE INDEX point_of_campaign ON point (campaign_id);

CREATE TABLE skipped (
  number      INTEGER PRIMARY KEY,
  campaign_id TEXT NOT NULL REFERENCES campaign (id),
  pose        INTEGER NOT NULL,
  reason      TEXT NOT NULL,
  attempts    INTEGER NOT NULL
) STRICT;
CREATE INDEX skipped_of_campaign ON skipped (campaign_id);

-- A campaign that identified the points of another. `validate`: the poses that validate; NULL: those measured for it.
CREATE TABLE identification (
  id        TEXT PRIMARY KEY REFERENCES campaign (id),
  points_of TEXT NOT NULL REFERENCES campaign (id),
  validate  TEXT CHECK (validate IS NULL OR json_valid(validate))
) STRICT;

-- What an interrupted campaign needs to continue.
CREATE TABLE plan (
  campaign_id TEXT PRIMARY KEY REFERENCES campaign (id),
  task        TEXT NOT NULL CHECK (json_valid(task)),
  total       INTEGER NOT NULL,
  identified  TEXT NOT NULL
) STRICT;
CREATE TABLE planned (
  campaign_id TEXT NOT NULL REFERENCES campaign (id),
  pose        INTEGER NOT NULL,
  purpose     TEXT NOT NULL
    CHECK (purpose IN ('identify', 'validate', 'remeasure', 'reference', 'target', 'cycle', 'frame')),
  q_target    TEXT NOT NULL CHECK (json_valid(q_target)),
  q_commanded TEXT NOT NULL CHECK (json_valid(q_commanded)),
  replaces    INTEGER,
  PRIMARY KEY (campaign_id, pose)
) STRICT;
CREATE TABLE resumption (
  number      INTEGER PRIMARY KEY,
  campaign_id TEXT NOT NULL REFERENCES campaign (id),
  interrupted TEXT NOT NULL,
  resumed     TEXT NOT NULL,
  found       TEXT NOT NULL,
  x_first_now TEXT NOT NULL CHECK (json_valid(x_first_now))
) STRICT;
CREATE INDEX resumption_of_campaign ON resumption (campaign_id);

CREATE TABLE model (
  id                     TEXT PRIMARY KEY,
  created                TEXT NOT NULL,
  campaign_id            TEXT NOT NULL,
  robot_serial           TEXT NOT NULL,
  yaml                   TEXT NOT NULL,
  validation_before_mm   REAL NOT NULL,
  validation_after_mm    REAL NOT NULL,
  active                 INTEGER NOT NULL CHECK (active IN (0, 1)),
  largest_correction_deg REAL NOT NULL,
  sha256                 TEXT NOT NULL
) STRICT;
CREATE UNIQUE INDEX one_active_model ON model (active) WHERE active = 1;
CREATE TABLE activation (
  number   INTEGER PRIMARY KEY,
  model_id TEXT NOT NULL REFERENCES model (id)
) STRICT;
CREATE TRIGGER model_activated AFTER UPDATE OF active ON model WHEN NEW.active=1
  BEGIN INSERT INTO activation (model_id) VALUES (NEW.id); END;

-- The campaign whose tool the stream uses.
CREATE TABLE tool (
  number      INTEGER PRIMARY KEY,
  campaign_id TEXT NOT NULL REFERENCES campaign (id)
) STRICT;

-- The stream stays armed over a restart.
CREATE TABLE armed (
  one   INTEGER PRIMARY KEY CHECK (one = 1),
  since TEXT NOT NULL
) STRICT;

-- `kept`: each event up to that number is in `event`, in a range of `event_gap`, or of a kind that is not kept.
CREATE TABLE event_number (
  one  INTEGER PRIMARY KEY CHECK (one = 1),
  last INTEGER NOT NULL,
  kept INTEGER NOT NULL
) STRICT;
INSERT INTO event_number VALUES (1, 0, 0);
CREATE TABLE event (
  seq   INTEGER PRIMARY KEY,
  time  TEXT NOT NULL,
  topic TEXT NOT NULL,
  data  TEXT NOT NULL CHECK (json_valid(data))
) STRICT;
CREATE INDEX event_of_time ON event (time);
CREATE TABLE event_gap (
  first  INTEGER PRIMARY KEY,
  last   INTEGER NOT NULL,
  reason TEXT NOT NULL
) STRICT;

-- Where the audit log ended, so that one that became shorter is found.
CREATE TABLE audit_head (
  count  INTEGER PRIMARY KEY,
  sha256 TEXT NOT NULL
) STRICT;
)sql";

constexpr std::array kStepsOfThisProgram{kVersion1};

}  // namespace

const SchemaSteps kSchemaSteps = kStepsOfThisProgram;

StoreResult<std::size_t> known_version(sqlite::Database& database, const std::string& file,
                                       SchemaSteps steps) {
  const StoreResult<std::string> application = database.value("PRAGMA application_id");
  if (!application) return std::unexpected(application.error());
  const StoreResult<std::string> version = database.value("PRAGMA user_version");
  if (!version) return std::unexpected(version.error());
  const StoreResult<std::string> tables = database.value("SELECT count(*) FROM sqlite_schema");
  if (!tables) return std::unexpected(tables.error());

  const bool fresh = *application == "0" && *version == "0" && *tables == "0";
  if (!fresh && *application != std::to_string(kApplicationId)) {
    return std::unexpected(StoreError{file + ": is a database of another program; choose another file"});
  }
  const std::size_t number = std::stoull(*version);
  if (number > steps.size()) {
    return std::unexpected(StoreError{file + ": was written by another truepose (schema " + *version +
                                      ", this one knows 1 to " + std::to_string(steps.size()) +
                                      "); update truepose or choose another file"});
  }
  return number;
}

StoreResult<void> migrate(sqlite::Database& database, const std::string& file, SchemaSteps steps) {
  const StoreResult<std::size_t> version = known_version(database, file, steps);
  if (!version) return std::unexpected(version.error());
  std::string sql;
  for (const char* const step : steps.subspan(*version)) sql += step;
  return database.execute(sql + "PRAGMA application_id=" + std::to_string(kApplicationId) +
                          ";PRAGMA user_version=" + std::to_string(steps.size()));
}

}  // namespace truepose::daemon
