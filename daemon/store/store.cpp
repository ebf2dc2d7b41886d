#include "daemon/store/store.hpp"

#include <algorithm>
#include <cmath>
#include <string_view>
#include <utility>

#include "core/planted_bug.hpp"
#include "daemon/store/campaign_plan.hpp"
#include "daemon/store/joint_list.hpp"
#include "daemon/store/sqlite.hpp"
#include "daemon/store/store_impl.hpp"
#include "daemon/store/store_schema.hpp"
#include "proto/text/digest.hpp"

namespace truepose::daemon {
namespace {

using sqlite::Database;
using sqlite::in;
using sqlite::Statement;
using sqlite::Transaction;

constexpr const char* kDeactivate = "UPDATE model SET active=0 WHERE active=1";

// Poses are numbered from 1; the database has counted them from 0 since its first version.
std::int64_t stored_pose(int number) { return number - 1; }
int pose_number(std::int64_t stored) { return static_cast<int>(stored) + 1; }

/// Of "[1,2]"; nothing of any other text.
std::optional<std::vector<int>> whole_numbers(std::string_view text) {
  const auto numbers = numbers_of(text);
  if (!numbers) return std::nullopt;
  return std::vector<int>(numbers->begin(), numbers->end());
}

using RowMajor3 = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;

bool finite(const std::optional<MeasuredOrientation>& orientation) {
  return !orientation || (orientation->R_WT.allFinite() && std::isfinite(orientation->sigma_rad));
}

bool finite(const StoredPoint& point) {
  return point.q_target.allFinite() && point.q_commanded.allFinite() && point.q_actual.allFinite() &&
         (!point.p_WS_mm || point.p_WS_mm->allFinite()) && finite(point.orientation) &&
         point.std_mm.allFinite() && std::isfinite(point.temperature_c) &&
         std::isfinite(point.pressure_mbar) && std::isfinite(point.humidity_percent);
}

constexpr std::size_t kOfRotation = 9;

/// The numbers of an orientation, exactly: R_WT row by row, then sigma_rad.
std::array<double, kOfRotation + 1> orientation_numbers(const MeasuredOrientation& orientation) {
  std::array<double, kOfRotation + 1> numbers{};
  Eigen::Map<RowMajor3>{numbers.data()} = orientation.R_WT;
  numbers.back() = orientation.sigma_rad;
  return numbers;
}

/// Nothing of a text that is none.
std::optional<MeasuredOrientation> orientation_of(std::string_view text) {
  const auto numbers = numbers_of(text);
  if (!numbers || numbers->size() != kOfRotation + 1) return std::nullopt;
  return MeasuredOrientation{Eigen::Map<const RowMajor3>{numbers->data()}, numbers->back()};
}

/// Of a campaign, as campaign_of() takes them; without its document, which may be long.
constexpr const char* kOutline =
    "SELECT id, started, ended, state, reason, robot_model, robot_serial, tracker_model, tracker_serial, "
    "model_id, '', kind, started_by, note, document_sha256 FROM campaign ";
constexpr const char* kWhole =
    "SELECT id, started, ended, state, reason, robot_model, robot_serial, tracker_model, tracker_serial, "
    "model_id, document, kind, started_by, note, document_sha256 FROM campaign ";

CampaignRecord campaign_of(const Statement& row) {
  return {.id = row.text(0),
          .kind = row.text(11),
          .started = row.text(1),
          .ended = row.text(2),
          .state = row.text(3),
          .reason = row.text(4),
          .robot_model = row.text(5),
          .robot_serial = row.text(6),
          .tracker_model = row.text(7),
          .tracker_serial = row.text(8),
          .model_id = row.text(9),
          .document = row.document(10),
          .document_sha256 = row.text(14),
          .started_by = row.text(12),
          .note = row.text(13)};
}

ModelRecord model_of(const Statement& row) {
  return {.id = row.text(0),
          .created = row.text(1),
          .campaign_id = row.text(2),
          .robot_serial = row.text(3),
          .yaml = row.document(4),
          .validation_before_mm = row.number(5),
          .validation_after_mm = row.number(6),
          .active = row.integer(7) != 0,
          .largest_correction_deg = row.number(8),
          .sha256 = row.text(9)};
}

template <typename Record>
StoreResult<std::vector<Record>> all(Statement query, Record (*of)(const Statement&)) {
  std::vector<Record> records;
  for (;;) {
    const StoreResult<bool> row = query.step();
    if (!row) return std::unexpected(row.error());
    if (!*row) return records;
    records.push_back(of(query));
  }
}

template <typename Record>
StoreResult<std::optional<Record>> first(Statement query, Record (*of)(const Statement&)) {
  const StoreResult<bool> row = query.step();
  if (!row) return std::unexpected(row.error());
  if (!*row) return std::nullopt;
  return of(query);
}

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

void assign_validation_set(const std::vector<int>& poses, std::vector<StoredPoint>& points) {
  for (StoredPoint& point : points) {
    if (point.purpose != PointPurpose::Identify && point.purpose != PointPurpose::Validate) continue;
    point.purpose =
        std::ranges::find(poses, point.pose) != poses.end() ? PointPurpose::Validate : PointPurpose::Identify;
  }
}

Statement Store::Impl::inserted(const ModelRecord& m) {
  Statement insert = database->prepare(
      "INSERT INTO model SELECT ?,?,?,?,?,?,?,0,?,? "
      "WHERE NOT EXISTS (SELECT 1 FROM model WHERE id=?1 AND sha256=?9)");
  insert.bind(m.id).bind(m.created).bind(m.campaign_id).bind(m.robot_serial).bind(m.yaml);
  insert.bind(m.validation_before_mm).bind(m.validation_after_mm);
  insert.bind(m.largest_correction_deg).bind(text::sha256_hex(m.yaml));
  return insert;
}

Statement Store::Impl::activated(const std::string& id) {
  Statement update = database->prepare("UPDATE model SET active=1 WHERE id=?");
  update.bind(id);
  return update;
}

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

StoreResult<void> Store::begin_campaign(const CampaignRecord& c, const std::string& order, int total) {
  Statement insert = impl_->database->prepare(
      "INSERT INTO campaign (id, started, ended, state, reason, robot_model, robot_serial, tracker_model, "
      "tracker_serial, model_id, document, kind, started_by, note) VALUES (?,?,?,?,?,?,?,?,?,?,?,?,?,?)");
  insert.bind(c.id)
      .bind(c.started)
      .bind(c.ended)
      .bind(c.state)
      .bind(c.reason)
      .bind(c.robot_model)
      .bind(c.robot_serial);
  insert.bind(c.tracker_model).bind(c.tracker_serial).bind(c.model_id).bind(c.document).bind(c.kind);
  insert.bind(c.started_by).bind(c.note);
  std::vector<Statement> further;
  if (!c.points_of.empty()) {
    further.push_back(impl_->database->prepare("INSERT INTO identification VALUES (?, ?, nullif(?, ''))"));
    further.back().bind(c.id).bind(c.points_of).bind(c.validate ? list_text(*c.validate) : "");
  }
  if (!order.empty()) further.push_back(plans().begun(c.id, order, total));
  std::vector<Statement*> all{&insert};
  for (Statement& statement : further) all.push_back(&statement);
  return impl_->commit("beginning campaign " + c.id, all);
}

CampaignPlans Store::plans() { return CampaignPlans{*impl_->database}; }

StoreResult<void> Store::add_point(const std::string& campaign_id, const StoredPoint& p) {
  const std::string operation = "storing a point of campaign " + campaign_id;
  if (!finite(p)) return std::unexpected(in(operation, {"a number is not finite"}));
  Statement insert = impl_->database->prepare(
      "INSERT INTO point (campaign_id, pose, purpose, q_target, q_commanded, q_actual, direction, smr, x_mm, "
      "y_mm, z_mm, std_x_mm, std_y_mm, std_z_mm, temperature_c, pressure_mbar, humidity_percent, time, "
      "resumption, orientation) SELECT ?,?,?,?,?,?,?,?,?,?,?,?,?,?,?,?,?,?,?,? WHERE NOT EXISTS (SELECT 1 FROM point WHERE "
      "campaign_id=?1 AND pose=?2 AND purpose=?3 AND q_actual=?6 AND smr=?8 AND x_mm IS ?9 AND time=?18)");
  insert.bind(campaign_id).bind(stored_pose(p.pose)).bind(purpose_name(p.purpose));
  insert.bind(list_text(p.q_target))
      .bind(list_text(p.q_commanded))
      .bind(list_text(p.q_actual))
      .bind(list_text(p.direction))
      .bind(p.smr);
  const Eigen::Vector3d seen_mm = p.p_WS_mm.value_or(Eigen::Vector3d(0, 0, 0));
  for (const double of_tracker : {seen_mm.x(), seen_mm.y(), seen_mm.z(), p.std_mm.x(), p.std_mm.y(),
                                  p.std_mm.z(), p.temperature_c, p.pressure_mbar, p.humidity_percent})
    insert.bind(p.p_WS_mm ? std::optional{of_tracker} : std::nullopt);
  insert.bind(p.time).bind(std::int64_t{p.resumption});
  if (p.orientation)
    insert.bind(list_text(orientation_numbers(*p.orientation)));
  else
    insert.bind(std::optional<double>{});
  return impl_->commit(operation, {&insert});
}

StoreResult<void> Store::add_skipped(const std::string& campaign_id, const SkippedPose& skipped) {
  Statement insert = impl_->database->prepare(
      "INSERT INTO skipped (campaign_id, pose, reason, attempts) SELECT ?,?,?,? WHERE NOT "
      "EXISTS (SELECT 1 FROM skipped WHERE campaign_id=?1 AND pose=?2 AND reason=?3 AND attempts=?4)");
  insert.bind(campaign_id)
      .bind(stored_pose(skipped.pose))
      .bind(skipped.reason)
      .bind(std::int64_t{skipped.attempts});
  return impl_->commit("storing a skipped pose of campaign " + campaign_id, {&insert});
}

StoreResult<void> Store::end_campaign(const CampaignRecord& c, const std::optional<ModelRecord>& made) {
  const std::string operation = "ending campaign " + c.id;
  const StoreResult<std::optional<CampaignRecord>> known = campaign(c.id);
  if (!known) return std::unexpected(in(operation, known.error()));
  if (!*known) return std::unexpected(in(operation, {"there is no such campaign"}));
  Statement update = impl_->database->prepare(
      "UPDATE campaign SET ended=?, state=?, reason=?, model_id=?, document=?, document_sha256=? WHERE id=?");
  update.bind(c.ended).bind(c.state).bind(c.reason).bind(c.model_id).bind(c.document);
  update.bind(text::sha256_hex(c.document)).bind(c.id);
  std::vector<Statement> of_model;
  if (made) of_model.push_back(impl_->inserted(*made));
  if (made && made->active) {
    of_model.push_back(impl_->database->prepare(kDeactivate));
    of_model.push_back(impl_->activated(made->id));
  }
  std::vector<Statement*> all{&update};
  for (Statement& statement : of_model) all.push_back(&statement);
  const StoreResult<void> ended = impl_->commit(operation, all);
  if (ended) impl_->gather();
  return ended;
}

StoreResult<std::vector<CampaignRecord>> Store::campaigns() {
  auto records = all<CampaignRecord>(impl_->database->prepare(kOutline + std::string{"ORDER BY rowid DESC"}),
                                     campaign_of);
  if (!records) return records;
  for (CampaignRecord& record : *records) {
    const StoreResult<void> named = impl_->name_source(record);
    if (!named) return std::unexpected(named.error());
  }
  return records;
}

StoreResult<std::optional<CampaignRecord>> Store::campaign(const std::string& id) {
  Statement query = impl_->database->prepare(kWhole + std::string{"WHERE id=?"});
  query.bind(id);
  return impl_->one_campaign(std::move(query));
}

StoreResult<std::optional<CampaignRecord>> Store::last_campaign() {
  return impl_->one_campaign(impl_->database->prepare(kWhole + std::string{"ORDER BY rowid DESC LIMIT 1"}));
}

StoreResult<std::optional<CampaignRecord>> Store::last_calibration() {
  return impl_->one_campaign(impl_->database->prepare(
      kWhole + std::string{"WHERE kind='calibration' AND state='done' ORDER BY rowid DESC LIMIT 1"}));
}

StoreResult<std::optional<CampaignRecord>> Store::Impl::one_campaign(Statement query) {
  auto record = first<CampaignRecord>(std::move(query), campaign_of);
  if (!record || !*record) return record;
  const StoreResult<void> named = name_source(**record);
  if (!named) return std::unexpected(named.error());
  return record;
}

StoreResult<void> Store::Impl::name_source(CampaignRecord& record) {
  Statement query =
      database->prepare("SELECT points_of, coalesce(validate, '') FROM identification WHERE id=?");
  query.bind(record.id);
  const StoreResult<bool> row = query.step();
  if (!row) return std::unexpected(row.error());
  if (!*row) return {};
  record.points_of = query.text(0);
  record.validate = whole_numbers(query.text(1));
  return {};
}

StoreResult<std::vector<StoredPoint>> Store::points(const std::string& campaign_id) {
  CampaignRecord of;
  of.id = campaign_id;
  const StoreResult<void> named = impl_->name_source(of);
  if (!named) return std::unexpected(named.error());
  auto points = impl_->measured(of.points_of.empty() ? campaign_id : of.points_of);
  if (points && of.validate) assign_validation_set(*of.validate, *points);
  return points;
}

StoreResult<std::vector<StoredPoint>> Store::Impl::measured(const std::string& campaign_id) {
  Statement query = database->prepare(
      "SELECT pose, purpose, q_target, q_commanded, q_actual, direction, smr, x_mm, y_mm, z_mm, std_x_mm, "
      "std_y_mm, std_z_mm, temperature_c, pressure_mbar, humidity_percent, time, resumption, orientation FROM "
      "point WHERE campaign_id=? ORDER BY number");
  query.bind(campaign_id);
  std::vector<StoredPoint> points;
  for (;;) {
    const StoreResult<bool> row = query.step();
    if (!row) return std::unexpected(row.error());
    if (!*row) return points;
    const auto target = joints_of(query.text(2)), commanded = joints_of(query.text(3)),
               actual = joints_of(query.text(4)), direction = joints_of(query.text(5));
    if (!target || !commanded || !actual || !direction) {
      return std::unexpected(
          StoreError{"reading campaign " + campaign_id + ": the joints of a point are no list of numbers"});
    }
    const auto purpose = purpose_of(query.text(1));
    if (!purpose)
      return std::unexpected(
          StoreError{"reading campaign " + campaign_id + ": a point has no purpose that is known"});
    std::optional<Eigen::Vector3d> seen_mm;
    if (!query.is_null(7)) seen_mm = Eigen::Vector3d(query.number(7), query.number(8), query.number(9));
    std::optional<MeasuredOrientation> orientation;
    if (!query.is_null(18)) {
      orientation = orientation_of(query.text(18));
      if (!orientation)
        return std::unexpected(
            StoreError{"reading campaign " + campaign_id + ": the orientation of a point is none"});
    }
    points.push_back({.pose = pose_number(query.integer(0)),
                      .purpose = *purpose,
                      .q_target = *target,
                      .q_commanded = *commanded,
                      .q_actual = *actual,
                      .direction = {direction->begin(), direction->end()},
                      .smr = query.text(6),
                      .p_WS_mm = seen_mm,
                      .orientation = orientation,
                      .std_mm = {query.number(10), query.number(11), query.number(12)},
                      .temperature_c = query.number(13),
                      .pressure_mbar = query.number(14),
                      .humidity_percent = query.number(15),
                      .time = query.text(16),
                      .resumption = static_cast<int>(query.integer(17))});
  }
}

StoreResult<std::vector<SkippedPose>> Store::skipped(const std::string& campaign_id) {
  Statement query = impl_->database->prepare(
      "SELECT pose, attempts, reason FROM skipped WHERE campaign_id=? ORDER BY number");
  query.bind(campaign_id);
  return all<SkippedPose>(std::move(query), [](const Statement& row) {
    return SkippedPose{pose_number(row.integer(0)), static_cast<int>(row.integer(1)), row.text(2)};
  });
}

StoreResult<void> Store::add_model(const ModelRecord& m) {
  Statement insert = impl_->inserted(m);
  return impl_->commit("storing model " + m.id, {&insert});
}

StoreResult<void> Store::activate_model(const std::string& id) {
  const std::string operation = id.empty() ? "deactivating the model" : "activating model " + id;
  if (!id.empty()) {
    const StoreResult<std::optional<ModelRecord>> known = model(id);
    if (!known) return std::unexpected(in(operation, known.error()));
    if (!*known) return std::unexpected(in(operation, {"there is no such model"}));
  }
  Statement none = impl_->database->prepare(kDeactivate), one = impl_->activated(id);
  return impl_->commit(operation, {&none, &one});
}

StoreResult<std::vector<ModelRecord>> Store::models() {
  return all<ModelRecord>(
      impl_->database->prepare(
          "SELECT id, created, campaign_id, robot_serial, '', "
          "validation_before_mm, validation_after_mm, active, largest_correction_deg, sha256"
          " FROM model ORDER BY rowid DESC"),
      model_of);
}

StoreResult<std::optional<ModelRecord>> Store::model(const std::string& id) {
  Statement query = impl_->database->prepare("SELECT * FROM model WHERE id=?");
  query.bind(id);
  return first<ModelRecord>(std::move(query), model_of);
}

StoreResult<std::optional<ModelRecord>> Store::active_model() {
  return first<ModelRecord>(impl_->database->prepare("SELECT * FROM model WHERE active=1"), model_of);
}

StoreResult<std::optional<ModelRecord>> Store::model_before() {
  return first<ModelRecord>(
      impl_->database->prepare("SELECT model.* FROM activation JOIN model ON model.id=activation.model_id "
                               "WHERE model.active=0 ORDER BY activation.number DESC LIMIT 1"),
      model_of);
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
  return all<ToolInUse>(impl_->database->prepare("SELECT number, campaign_id FROM tool ORDER BY number"),
                        +tool_of);
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
  return all<control::AuditHead>(
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
