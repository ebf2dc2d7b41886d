#include "daemon/store/store_schema.hpp"

#include "daemon/store/campaign_plan.hpp"
#include "daemon/store/store_impl.hpp"

namespace truepose::daemon {
namespace {

constexpr std::int64_t kApplicationId = 0x54505345;  // "TPSE", so that `file` and we know our own

constexpr const char* kSchema1 = R"sql(
CREATE TABLE campaign (
  id             TEXT PRIMARY KEY,
  started        TEXT NOT NULL,
  ended          TEXT NOT NULL,
  state          TEXT NOT NULL CHECK (state IN ('running', 'done', 'aborted', 'failed')),
  reason         TEXT NOT NULL,
  robot_model    TEXT NOT NULL,
  robot_serial   TEXT NOT NULL,
  tracker_model  TEXT NOT NULL,
  tracker_serial TEXT NOT NULL,
  model_id       TEXT NOT NULL,
  document       TEXT NOT NULL
) STRICT;
CREATE TABLE point (
  number           INTEGER PRIMARY KEY,
  campaign_id      TEXT NOT NULL REFERENCES campaign (id),
  pose             INTEGER NOT NULL,
  purpose          TEXT NOT NULL CHECK (purpose IN ('identify', 'validate', 'remeasure')),
  q_target         TEXT NOT NULL CHECK (json_valid(q_target)),
  q_commanded      TEXT NOT NULL CHECK (json_valid(q_commanded)),
  q_actual         TEXT NOT NULL CHECK (json_valid(q_actual)),
  smr              TEXT NOT NULL,
  x_mm             REAL NOT NULL,
  y_mm             REAL NOT NULL,
  z_mm             REAL NOT NULL,
  std_x_mm         REAL NOT NULL,
  std_y_mm         REAL NOT NULL,
  std_z_mm         REAL NOT NULL,
  temperature_c    REAL NOT NULL,
  pressure_mbar    REAL NOT NULL,
  humidity_percent REAL NOT NULL,
  time             TEXT NOT NULL
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
CREATE TABLE model (
  id                      TEXT PRIMARY KEY,
  created                 TEXT NOT NULL,
  campaign_id             TEXT NOT NULL,
  robot_serial            TEXT NOT NULL,
  yaml                    TEXT NOT NULL,
  validation_before_mm    REAL NOT NULL,
  validation_geometric_mm REAL NOT NULL,
  active                  INTEGER NOT NULL CHECK (active IN (0, 1))
) STRICT;
CREATE UNIQUE INDEX one_active_model ON model (active) WHERE active = 1;
CREATE TABLE event_number (
  one  INTEGER PRIMARY KEY CHECK (one = 1),
  last INTEGER NOT NULL
) STRICT;
INSERT INTO event_number VALUES (1, 0);
)sql";

// Points know from which side their joints came, the reference pose is a purpose of its own, and a campaign
// may be a drift check.
constexpr const char* kSchema2 = R"sql(
CREATE TABLE new_point (
  number           INTEGER PRIMARY KEY,
  campaign_id      TEXT NOT NULL REFERENCES campaign (id),
  pose             INTEGER NOT NULL,
  purpose          TEXT NOT NULL CHECK (purpose IN ('identify', 'validate', 'remeasure', 'reference')),
  q_target         TEXT NOT NULL CHECK (json_valid(q_target)),
  q_commanded      TEXT NOT NULL CHECK (json_valid(q_commanded)),
  q_actual         TEXT NOT NULL CHECK (json_valid(q_actual)),
  direction        TEXT NOT NULL CHECK (json_valid(direction)),
  smr              TEXT NOT NULL,
  x_mm             REAL NOT NULL,
  y_mm             REAL NOT NULL,
  z_mm             REAL NOT NULL,
  std_x_mm         REAL NOT NULL,
  std_y_mm         REAL NOT NULL,
  std_z_mm         REAL NOT NULL,
  temperature_c    REAL NOT NULL,
  pressure_mbar    REAL NOT NULL,
  humidity_percent REAL NOT NULL,
  time             TEXT NOT NULL
) STRICT;
INSERT INTO new_point SELECT number, campaign_id, pose, purpose, q_target, q_commanded, q_actual, '[]', smr, x_mm, y_mm,
  z_mm, std_x_mm, std_y_mm, std_z_mm, temperature_c, pressure_mbar, humidity_percent, time FROM point;
DROP TABLE point;
ALTER TABLE new_point RENAME TO point;
CREATE INDEX point_of_campaign ON point (campaign_id);
ALTER TABLE campaign ADD COLUMN kind TEXT NOT NULL DEFAULT 'calibration' CHECK (kind IN ('calibration', 'drift'));
ALTER TABLE model RENAME COLUMN validation_geometric_mm TO validation_after_mm;
)sql";

// Campaigns may drive to targets with the tracker in the loop, or run the cycles of an ISO 9283 test.
constexpr const char* kSchema3 = R"sql(
CREATE TABLE new_point (
  number           INTEGER PRIMARY KEY,
  campaign_id      TEXT NOT NULL REFERENCES campaign (id),
  pose             INTEGER NOT NULL,
  purpose          TEXT NOT NULL
                   CHECK (purpose IN ('identify', 'validate', 'remeasure', 'reference', 'target', 'cycle')),
  q_target         TEXT NOT NULL CHECK (json_valid(q_target)),
  q_commanded      TEXT NOT NULL CHECK (json_valid(q_commanded)),
  q_actual         TEXT NOT NULL CHECK (json_valid(q_actual)),
  direction        TEXT NOT NULL CHECK (json_valid(direction)),
  smr              TEXT NOT NULL,
  x_mm             REAL NOT NULL,
  y_mm             REAL NOT NULL,
  z_mm             REAL NOT NULL,
  std_x_mm         REAL NOT NULL,
  std_y_mm         REAL NOT NULL,
  std_z_mm         REAL NOT NULL,
  temperature_c    REAL NOT NULL,
  pressure_mbar    REAL NOT NULL,
  humidity_percent REAL NOT NULL,
  time             TEXT NOT NULL
) STRICT;
INSERT INTO new_point SELECT number, campaign_id, pose, purpose, q_target, q_commanded, q_actual, direction, smr, x_mm,
  y_mm, z_mm, std_x_mm, std_y_mm, std_z_mm, temperature_c, pressure_mbar, humidity_percent, time FROM point;
DROP TABLE point;
ALTER TABLE new_point RENAME TO point;
CREATE INDEX point_of_campaign ON point (campaign_id);
ALTER TABLE campaign RENAME COLUMN kind TO old_kind;
ALTER TABLE campaign ADD COLUMN kind TEXT NOT NULL DEFAULT 'calibration'
  CHECK (kind IN ('calibration', 'drift', 'targets', 'iso9283'));
UPDATE campaign SET kind = old_kind;
ALTER TABLE campaign DROP COLUMN old_kind;
)sql";

// Models carry what shows that they are still the ones that were made. Those from before carry nothing: a
// hash given to them now would vouch for whatever became of them.
constexpr const char* kSchema4 = R"sql(
ALTER TABLE model ADD COLUMN largest_correction_deg REAL NOT NULL DEFAULT 0;
ALTER TABLE model ADD COLUMN sha256 TEXT NOT NULL DEFAULT '';
)sql";

/// Whether the stream is armed, which outlives the daemon.
constexpr const char* kSchema5 = R"sql(
CREATE TABLE armed (
  one   INTEGER PRIMARY KEY CHECK (one = 1),
  since TEXT NOT NULL
) STRICT;
)sql";

// Reflectors that stand beside the arm are measured too, and points in both faces of the tracker.
constexpr const char* kSchema6 = R"sql(
ALTER TABLE point RENAME COLUMN purpose TO old_purpose;
ALTER TABLE point ADD COLUMN purpose TEXT NOT NULL DEFAULT 'identify'
  CHECK (purpose IN ('identify', 'validate', 'remeasure', 'reference', 'target', 'cycle', 'nest', 'face1'));
UPDATE point SET purpose = old_purpose;
ALTER TABLE point DROP COLUMN old_purpose;
)sql";

// Campaigns know who started them and what for, and models when each was the active one, whoever made it
// that.
constexpr const char* kSchema7 = R"sql(
ALTER TABLE campaign ADD COLUMN started_by TEXT NOT NULL DEFAULT '';
ALTER TABLE campaign ADD COLUMN note TEXT NOT NULL DEFAULT '';
CREATE TABLE activation (
  number   INTEGER PRIMARY KEY,
  model_id TEXT NOT NULL REFERENCES model (id)
) STRICT;
INSERT INTO activation (model_id) SELECT id FROM model WHERE active=1;
CREATE TRIGGER model_activated AFTER UPDATE OF active ON model WHEN NEW.active=1
  BEGIN INSERT INTO activation (model_id) VALUES (NEW.id); END;
)sql";

// A campaign may be an identification of the points of another. `validate` lists the poses that validate
// there (JSON); NULL: those that were measured to.
constexpr const char* kIdentificationSchema = R"sql(
CREATE TABLE identification (
  id        TEXT PRIMARY KEY REFERENCES campaign (id),
  points_of TEXT NOT NULL REFERENCES campaign (id),
  validate  TEXT CHECK (validate IS NULL OR json_valid(validate))
) STRICT;
)sql";

// Campaigns may measure a tool or a work frame, by the points of its frame; of each tool's number one that
// was measured may be in force.
constexpr const char* kSchema10 = R"sql(
ALTER TABLE campaign RENAME COLUMN kind TO old_kind;
ALTER TABLE campaign ADD COLUMN kind TEXT NOT NULL DEFAULT 'calibration'
  CHECK (kind IN ('calibration', 'drift', 'targets', 'iso9283', 'tool', 'base'));
UPDATE campaign SET kind = old_kind;
ALTER TABLE campaign DROP COLUMN old_kind;
ALTER TABLE point RENAME COLUMN purpose TO old_purpose;
ALTER TABLE point ADD COLUMN purpose TEXT NOT NULL DEFAULT 'identify' CHECK (purpose IN
  ('identify', 'validate', 'remeasure', 'reference', 'target', 'cycle', 'nest', 'face1', 'check', 'frame'));
UPDATE point SET purpose = old_purpose;
ALTER TABLE point DROP COLUMN old_purpose;
ALTER TABLE planned RENAME COLUMN purpose TO old_purpose;
ALTER TABLE planned ADD COLUMN purpose TEXT NOT NULL DEFAULT 'identify'
  CHECK (purpose IN ('identify', 'validate', 'remeasure', 'reference', 'target', 'cycle', 'frame'));
UPDATE planned SET purpose = old_purpose;
ALTER TABLE planned DROP COLUMN old_purpose;
CREATE TABLE tool (
  number      INTEGER PRIMARY KEY,
  campaign_id TEXT NOT NULL REFERENCES campaign (id)
) STRICT;
)sql";

// A point of a fixture may be touched by the arm's TCP, and then no tracker tells of it.
constexpr const char* kSchema11 = R"sql(
CREATE TABLE new_point (
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
  resumption       INTEGER NOT NULL DEFAULT 0
) STRICT;
INSERT INTO new_point SELECT number, campaign_id, pose, purpose, q_target, q_commanded, q_actual, direction, smr, x_mm,
  y_mm, z_mm, std_x_mm, std_y_mm, std_z_mm, temperature_c, pressure_mbar, humidity_percent, time, resumption FROM point;
DROP TABLE point;
ALTER TABLE new_point RENAME TO point;
CREATE INDEX point_of_campaign ON point (campaign_id);
)sql";

// Documents carry what shows that they are still the ones that campaigns ended with: a tool is in one. Those
// from before carry nothing, as models from before do.
constexpr const char* kSchema12 = R"sql(
ALTER TABLE campaign ADD COLUMN document_sha256 TEXT NOT NULL DEFAULT '';
)sql";

// The store knows where the audit trail ended, so that one that became shorter is found.
constexpr const char* kSchema13 = R"sql(
CREATE TABLE audit_head (
  count  INTEGER PRIMARY KEY,
  sha256 TEXT NOT NULL
) STRICT;
)sql";

// Points of 6-D targets have an orientation: R_WT row by row, then its standard deviation (rad).
constexpr const char* kSchema14 = R"sql(
ALTER TABLE point ADD COLUMN orientation TEXT CHECK (orientation IS NULL OR json_valid(orientation));
)sql";

}  // namespace

StoreResult<int> known_version(sqlite::Database& database, const std::string& file) {
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
  if (std::stoll(*version) > kSchemaVersion) {
    return std::unexpected(StoreError{file + ": was written by a newer truepose (schema " + *version +
                                      ", this one knows " + std::to_string(kSchemaVersion) +
                                      "); update truepose or choose another file"});
  }
  return std::stoi(*version);
}

StoreResult<void> migrate(sqlite::Database& database, const std::string& file) {
  const StoreResult<int> version = known_version(database, file);
  if (!version) return std::unexpected(version.error());
  std::string steps;
  if (*version == 0) steps += kSchema1 + ("PRAGMA application_id=" + std::to_string(kApplicationId)) + ";";
  if (*version < 2) steps += kSchema2;
  if (*version < 3) steps += kSchema3;
  if (*version < 4) steps += kSchema4;
  if (*version < 5) steps += kSchema5;
  if (*version < 6) steps += kSchema6;
  if (*version < 7) steps += kSchema7;
  if (*version < 8) steps += kEventSchema + std::string{kIdentificationSchema};
  if (*version < 9) steps += CampaignPlans::kSchema;
  if (*version < 10) steps += kSchema10;
  if (*version < 11) steps += kSchema11;
  if (*version < 12) steps += kSchema12;
  if (*version < 13) steps += kSchema13;
  if (*version < 14) steps += kSchema14;
  return database.execute(steps + "PRAGMA user_version=" + std::to_string(kSchemaVersion));
}

}  // namespace truepose::daemon
