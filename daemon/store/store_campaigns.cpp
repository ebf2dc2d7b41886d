#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "daemon/store/campaign_plan.hpp"
#include "daemon/store/joint_list.hpp"
#include "daemon/store/store_impl.hpp"
#include "proto/text/digest.hpp"

namespace truepose::daemon {

using sqlite::in;
using sqlite::Statement;

namespace {

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

}  // namespace

void assign_validation_set(const std::vector<int>& poses, std::vector<StoredPoint>& points) {
  for (StoredPoint& point : points) {
    if (point.purpose != PointPurpose::Identify && point.purpose != PointPurpose::Validate) continue;
    point.purpose =
        std::ranges::find(poses, point.pose) != poses.end() ? PointPurpose::Validate : PointPurpose::Identify;
  }
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
    of_model.push_back(impl_->none_active());
    of_model.push_back(impl_->activated(made->id));
  }
  std::vector<Statement*> all{&update};
  for (Statement& statement : of_model) all.push_back(&statement);
  const StoreResult<void> ended = impl_->commit(operation, all);
  if (ended) impl_->gather();
  return ended;
}

StoreResult<std::vector<CampaignRecord>> Store::campaigns() {
  auto records = all_records<CampaignRecord>(
      impl_->database->prepare(kOutline + std::string{"ORDER BY rowid DESC"}), campaign_of);
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
  auto record = first_record<CampaignRecord>(std::move(query), campaign_of);
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
  return all_records<SkippedPose>(std::move(query), [](const Statement& row) {
    return SkippedPose{pose_number(row.integer(0)), static_cast<int>(row.integer(1)), row.text(2)};
  });
}

}  // namespace truepose::daemon
