#include "daemon/campaign/store_journal.hpp"

#include <algorithm>
#include <boost/algorithm/string/case_conv.hpp>
#include <boost/json/object.hpp>
#include <cmath>
#include <iterator>
#include <set>
#include <utility>

#include "config/cell_setup.hpp"
#include "config/model_update.hpp"
#include "core/arm/joint_units.hpp"
#include "core/compensate/largest_correction.hpp"
#include "core/math/units.hpp"
#include "core/planted_bug.hpp"
#include "daemon/campaign/corrected_points.hpp"
#include "daemon/campaign/stored_model.hpp"
#include "proto/control/json_text.hpp"
#include "proto/record/calibration_content.hpp"
#include "proto/record/calibration_document.hpp"
#include "proto/record/drift_document.hpp"
#include "proto/record/forms.hpp"
#include "proto/record/frame_document.hpp"
#include "proto/record/json_io.hpp"
#include "proto/rpc/campaign.hpp"

namespace truepose::daemon {

namespace asio = boost::asio;
namespace json = boost::json;

namespace {

record::Extent extent_of(const std::vector<StoredPoint>& points, double StoredPoint::*quantity) {
  const auto [min, max] = std::ranges::minmax(points, {}, quantity);
  return {min.*quantity, max.*quantity};
}

/// "Campaign 0f8418ae, started by Anna: after the new gripper"
std::string campaign_text(const CampaignRecord& record) {
  std::string text = "Campaign " + record.id.substr(0, 8);
  if (!record.started_by.empty()) text += ", started by " + record.started_by;
  if (!record.note.empty()) text += ": " + record.note;
  return text;
}

int poses_of(const std::vector<StoredPoint>& points) {
  std::set<int> poses;
  for (const StoredPoint& point : points)
    if (is_pose(point.purpose) && point.purpose != PointPurpose::Reference) poses.insert(point.pose);
  return static_cast<int>(poses.size());
}

/// The campaign that measured.
const CampaignRecord& measured_in(const StoreJournal::Options& options, const CampaignRecord& record) {
  return options.source ? *options.source : record;
}

/// The ranges are over all points, and left out if the tracker reported no air pressure, as one without a
/// weather station. Measurements of the reference pose and of nests are not counted.
record::Conditions conditions_of(const CampaignResult& result, const CampaignRecord& record) {
  const std::vector<StoredPoint>& points = result.points;
  record::Conditions conditions{.started = record.started,
                                .ended = record.ended,
                                .poses_measured = poses_of(points),
                                .poses_skipped = static_cast<int>(result.skipped.size())};
  if (points.empty() || std::ranges::max(points, {}, &StoredPoint::pressure_mbar).pressure_mbar <= 0)
    return conditions;
  conditions.temperature_c = extent_of(points, &StoredPoint::temperature_c);
  conditions.pressure_mbar = extent_of(points, &StoredPoint::pressure_mbar);
  conditions.humidity_percent = extent_of(points, &StoredPoint::humidity_percent);
  return conditions;
}

/// How a campaign of the cell chooses its poses and identifies, in words: {"Poses planned": "30 to identify,
/// 30 to validate", ...}.
record::ByName<std::string> options_in_words(const StoreJournal::Options& of) {
  const config::CellConfig& config = of.config;
  const config::CampaignConfig& campaign = config.campaign;
  record::ByName<std::string> options;
  if (!of.source)
    options = {
        {"Poses planned", std::to_string(campaign.identify_poses) + " to identify, " +
                              std::to_string(campaign.validate_poses) + " to validate"},
        {"Poses chosen", boost::to_upper_copy(std::string{name_of(record::kCriteria, campaign.criterion)}) +
                             "-optimal, of " + std::to_string(campaign.candidates) + " candidates"}};
  std::ranges::move(record::options_in_words(config::calibrate_options(config)), std::back_inserter(options));
  return options;
}

/// Errors of the points measured again (wanted minus measured, as in "points"), with the numbers of their
/// validation poses.
std::vector<record::Remeasured> remeasured_points(const CampaignResult& result,
                                                  const config::CellConfig& config) {
  const std::vector<StoredPoint> corrected =
      corrected_points(result.points, config, result.resumptions).points;
  std::vector<record::Remeasured> points;
  for (const auto& [point, error_mm] : result.as<CalibrationResult>().remeasured_points) {
    const StoredPoint* const before = validation_of(point, corrected);
    if (before == nullptr) continue;  // of no use for validation: no corrected point to compare it with
    points.push_back({before->pose, point.smr, -error_mm});
  }
  return points;
}

/// Whole 0.1 um: further digits mean nothing, and a hundred targets are to fit into one message.
double rounded(double mm) { return std::round(mm * 1e4) / 1e4; }

rpc::TargetsDocument targets_document(const TargetsResult& result, const RobotModel& robot) {
  const auto reached = std::ranges::count(result.targets, true, &TargetOutcome::reached);
  rpc::TargetsDocument document{.tolerance_mm = result.loop.tolerance_mm,
                                .rounds = result.loop.rounds,
                                .readings = result.readings,
                                .reached = static_cast<int>(reached)};
  for (const TargetOutcome& outcome : result.targets) {
    rpc::TargetsDocument::Target target{.target = static_cast<int>(document.targets.size()) + 1,
                                        .reached = outcome.reached,
                                        .reason = outcome.reason,
                                        .joints_deg = in_deg_mm(outcome.q, robot),
                                        .averaged_mm = rounded(outcome.averaged_error_mm)};
    std::ranges::transform(outcome.errors_mm, std::back_inserter(target.errors_mm), rounded);
    document.targets.push_back(std::move(target));
  }
  return document;
}

rpc::Iso9283Document iso9283_document_of(const Iso9283Test& test) {
  rpc::Iso9283Document document{.test = record::iso9283_of(test.result, test.points, test.frame),
                                .compensated = test.compensated,
                                .cube = {test.cube.X_BC.translation(), test.cube.edge_mm}};
  for (const Iso9283Stop& stop : test.stops) {
    const TestPoint& point = test.points[stop.point];
    document.commanded.push_back({point.name, stop.direction, point.commanded.p_mm});
  }
  return document;
}

/// The document that reports are made of: that of the calibration, what measuring again has shown, and how it
/// was measured.
json::object calibration_document_of(const CampaignResult& result, const CampaignRecord& record,
                                     const StoreJournal::Options& of) {
  const config::CellConfig& config = of.config;
  const auto& found = result.as<CalibrationResult>();
  const MeasurementData data = campaign_data(result.points, config, result.resumptions);
  record::CalibrationDocument document = record::calibration_of(found.calibration, data, found.elapsed_s);
  document.campaign =
      campaign_text(record) + (of.source ? ", of the points of campaign " + of.source->id.substr(0, 8) : "");
  document.robot = record.robot_model + ", serial " + record.robot_serial;
  document.tracker = record.tracker_model + ", serial " + record.tracker_serial;
  document.model = record.model_id;
  document.date = record.ended;
  document.options = options_in_words(of);
  document.verdict = found.verdict;
  document.noise = config::calibrate_options(config).noise;
  document.conditions = conditions_of(result, measured_in(of, record));
  document.interruptions = {result.resumptions.begin(), result.resumptions.end()};
  document.remeasured = found.remeasured;
  if (found.remeasured) document.remeasured_points = remeasured_points(result, config);
  document.reference_drift_mm = found.reference_drift_mm;
  document.skipped = result.skipped;
  return record::calibration_document(document);
}

json::object drift_document_of(const DriftResult& drift, std::span<const Measurement> points) {
  record::DriftDocument document = record::drift_of(drift.check, drift.order.reference, points);
  if (drift.update) document.update = record::update_of(*drift.update, points);
  return record::drift_document(document);
}

/// With the file of the tool, where nothing speaks against using it.
record::FrameDocument tool_document_of(const ToolResult& tool, const RobotModel& robot,
                                       const std::string& serial) {
  const Eigen::Isometry3d X_controller = config::rounded_for_controller(tool.frame.X);
  record::FrameDocument document = record::frame_document_of(
      record::FrameKind::Tool, tool.order.number, tool.data, tool.frame, X_controller, tool.order.by);
  if (tool.frame.is_sound())
    document.yaml = config::tool_yaml({tool.order.number, robot.name, serial, X_controller, tool.data});
  return document;
}

record::FrameDocument base_document_of(const BaseResult& base, const RobotModel& robot) {
  const Eigen::Isometry3d X_controller = config::rounded_for_controller(base.frame.X);
  record::FrameDocument document = record::frame_document_of(
      record::FrameKind::Base, base.order.number, base.data, base.frame, X_controller, base.order.by);
  if (base.order.touch) document.touched_by = base.order.touch->tool.number;
  if (base.frame.is_sound()) {
    config::BaseFile file{base.order.number,     robot.name, base.order.model_made, X_controller,
                          base.frame.covariance, base.data};
    if (base.order.touch) file.touched_by_mm = base.order.touch->measured.X.translation();
    document.yaml = config::base_yaml(file);
  }
  return document;
}

/// Of a campaign that measured a tool or a base.
std::optional<record::FrameDocument> frame_document_of(const CampaignFindings& findings,
                                                       const RobotModel& robot, const std::string& serial) {
  if (const auto* tool = std::get_if<ToolResult>(&findings)) return tool_document_of(*tool, robot, serial);
  if (const auto* base = std::get_if<BaseResult>(&findings)) return base_document_of(*base, robot);
  return std::nullopt;
}

std::string document_of(const CampaignResult& result, const CampaignRecord& record,
                        const StoreJournal::Options& of) {
  const config::CellConfig& config = of.config;
  if (const auto* drift = std::get_if<DriftResult>(&result.findings))
    return control::json_text(drift_document_of(
        *drift, numbered_points(corrected_points(result.points, config, result.resumptions).points)));
  if (const auto* targets = std::get_if<TargetsResult>(&result.findings))
    return control::json_text(record::to_json(targets_document(*targets, config.robot.model)));
  if (const auto* test = std::get_if<Iso9283Test>(&result.findings))
    return control::json_text(record::to_json(iso9283_document_of(*test)));
  if (const auto frame = frame_document_of(result.findings, config.robot.model, record.robot_serial))
    return control::json_text(record::frame_document(*frame));
  return control::json_text(calibration_document_of(result, record, of));
}

config::ModelFile updated_model_of(const DriftResult& drift, const std::string& created) {
  const ModelRecord& old = drift.order.model;
  return config::updated_model(config::parse_model(old.yaml, "model " + old.id), *drift.update, old.id,
                               created);
}

/// Mean errors of what the campaign's model is compared with and of itself, where it was not made from the
/// points; 0: nothing was validated.
std::pair<double, double> validated_mm(const CampaignResult& result) {
  if (const auto* drift = std::get_if<DriftResult>(&result.findings))
    return {drift->update->before_mm, drift->update->left_out_mm};
  const auto& validate = result.as<CalibrationResult>().calibration.validate;
  return validate ? std::pair{validate->before.mean, validate->after.mean} : std::pair{0.0, 0.0};
}

std::string why_not_activated(const CalibrationVerdict& verdict) {
  std::string text = "the model was not activated: ";
  for (const Finding& finding : verdict.findings)
    if (finding.severity >= Severity::Warning) text += finding.sentence + "; ";
  return text + "look into that and identify again, or activate it by hand";
}

}  // namespace

StoreJournal::StoreJournal(Options options, Store& store, Worker& store_thread, drivers::WallClock wall_clock,
                           const drivers::Clock& steady_clock)
    : options_{std::move(options)},
      store_{store},
      store_thread_{store_thread},
      wall_clock_{wall_clock},
      point_clock_{std::move(wall_clock), steady_clock, options_.measured_before} {
  if (options_.interrupted) {
    record_ = *options_.interrupted;
    record_.reason.clear();
    record_.ended.clear();
    begun_ = true;
  } else {
    record_.id = options_.campaign_id;
    record_.kind = options_.kind;
    record_.started = control::rfc3339(wall_clock_());
    record_.started_by = options_.started_by;
    record_.note = options_.note;
    record_.validate = options_.validate;
    if (options_.source) record_.points_of = options_.source->id;
  }
  record_.state = "running";
}

asio::awaitable<StoreResult<std::string>> StoreJournal::begin(int total) {
  const bool resumes = options_.interrupted.has_value();
  const std::string time = resumes ? control::rfc3339(wall_clock_()) : record_.started;
  auto job = [this, resumes, total, record = record_] {
    return resumes ? store_.plans().resume(record.id) : store_.begin_campaign(record, options_.order, total);
  };
  auto begun = co_await store_thread_.ask(job);
  if (!begun) co_return std::unexpected(begun.error());
  begun_ = true;
  co_return time;
}

asio::awaitable<StoreResult<void>> StoreJournal::know(Identities identities) {
  record_.robot_model = identities.robot.model;
  record_.robot_serial = identities.robot.serial;
  record_.tracker_model = identities.tracker.model;
  record_.tracker_serial = identities.tracker.serial;
  auto job = [this, record = record_] { return store_.plans().keep_identities(record); };
  co_return co_await store_thread_.ask(job);
}

asio::awaitable<StoreResult<void>> StoreJournal::add_planned(std::vector<PlannedPose> poses, int total) {
  if (options_.order.empty()) co_return StoreResult<void>{};
  auto job = [this, poses = std::move(poses), total] {
    return store_.plans().add_planned(options_.campaign_id, poses, total);
  };
  co_return co_await store_thread_.ask(job);
}

asio::awaitable<StoreResult<void>> StoreJournal::add_identified(std::string sha256) {
  if (options_.order.empty()) co_return StoreResult<void>{};
  auto job = [this, sha256] { return store_.plans().keep_identified(options_.campaign_id, sha256); };
  co_return co_await store_thread_.ask(job);
}

asio::awaitable<StoreResult<void>> StoreJournal::add_resumption(Resumption resumption) {
  auto job = [this, resumption] { return store_.plans().add_resumption(options_.campaign_id, resumption); };
  co_return co_await store_thread_.ask(job);
}

asio::awaitable<StoreResult<StoredPoint>> StoreJournal::add_point(StoredPoint point) {
  point.time = control::rfc3339(point_clock_.now());
  auto job = [this, point] { return store_.add_point(options_.campaign_id, point); };
  auto kept = co_await store_thread_.ask(job);
  if (!kept) co_return std::unexpected(kept.error());
  co_return point;
}

asio::awaitable<StoreResult<void>> StoreJournal::add_skipped(SkippedPose skipped) {
  auto job = [this, skipped] { return store_.add_skipped(options_.campaign_id, skipped); };
  co_return co_await store_thread_.ask(job);
}

asio::awaitable<StoreResult<void>> StoreJournal::end(std::shared_ptr<const CampaignResult> result,
                                                     std::optional<CampaignError> error) {
  record_.ended = control::rfc3339(wall_clock_());
  record_.state = "done";
  if (error) {
    record_.state = error->interrupted                       ? "interrupted"
                    : error->fault == CampaignFault::Aborted ? "aborted"
                                                             : "failed";
    record_.reason = error->detail;
  }
  const auto* calibrated = result ? std::get_if<CalibrationResult>(&result->findings) : nullptr;
  const auto* drift = result ? std::get_if<DriftResult>(&result->findings) : nullptr;
  const bool updated = drift && drift->updated();
  const bool sound = calibrated ? !calibrated->verdict.failed() : updated;
  const bool activate = sound && options_.activate;
  if (calibrated && options_.activate && !activate) record_.reason = why_not_activated(calibrated->verdict);
  if (const auto frame =
          result ? frame_document_of(result->findings, options_.config.robot.model, record_.robot_serial)
                 : std::nullopt) {
    const std::string why = record::why_not_usable(*frame);
    if (!why.empty()) record_.reason = "the frame cannot be used: " + why;
  }
  if (calibrated || updated) record_.model_id = options_.model_id;
  // There, because making the document takes longer than the event loop may be held.
  auto document = [record = record_, result, this] {
    return result ? document_of(*result, record, options_) : std::string{};
  };
  record_.document = co_await store_thread_.ask(document);
  auto make_model = [this, ended = record_.ended, result, calibrated, updated, activate] {
    std::optional<ModelRecord> model;
    if (calibrated) model = model_of(*result, calibrated_model(*result), activate);
    if (updated) model = model_of(*result, updated_model_of(result->as<DriftResult>(), ended), activate);
    return model;
  };
  model_ = co_await store_thread_.ask(make_model);
  co_return co_await end_again();
}

asio::awaitable<StoreResult<void>> StoreJournal::end_again() {
  auto job = [this, record = record_, model = model_, begun = begun_] {
    // Of one that could not even be begun, all that there is.
    return begun ? store_.end_campaign(record, model) : store_.begin_campaign(record);
  };
  auto kept = co_await store_thread_.ask(job);
  ended_ = kept.has_value();
  activated_ = kept && model_ && model_->active;
  co_return kept;
}

config::ModelFile StoreJournal::calibrated_model(const CampaignResult& result) const {
  const auto& found = result.as<CalibrationResult>();
  const auto& validate = found.calibration.validate;
  config::ModelFile file;
  file.name = options_.config.robot.model.name;
  file.serial = result.identities.robot.serial;
  file.created = record_.ended;
  file.cell = found.calibration.cell;
  file.parameters = found.calibration.parameters;
  file.covariance = found.calibration.covariance;
  file.noise = found.noise;
  file.misfit_mm = found.calibration.misfit_mm;
  file.validation_distances2 = found.validation_distances2;
  file.verdict = found.verdict;
  if (validate) file.validation_mean_mm = validate->after.mean;
  file.validation = config::validation_points(
      as_fitted(found.calibration, campaign_data(result.points, options_.config, result.resumptions)));
  file.largest_correction_deg =
      largest_correction(options_.config.robot.model, file.cell, config::poses_of(file.validation)) *
      kDegPerRad;
  if (result.resumptions.empty() || planted("a model of a resumed campaign stays in its first station"))
    return file;
  // The model is used with the tracker as it stands now.
  return config::seen_from(std::move(file), result.resumptions.back().X_first_now.inverse());
}

ModelRecord StoreJournal::model_of(const CampaignResult& result, const config::ModelFile& file,
                                   bool active) const {
  ModelRecord model;
  model.id = options_.model_id;
  model.created = record_.ended;
  model.campaign_id = options_.campaign_id;
  model.robot_serial = file.serial;
  model.yaml = config::model_yaml(file);
  model.active = active;
  model.largest_correction_deg =
      largest_correction(options_.config.robot.model, file.cell, poses_of_task(result.points)) * kDegPerRad;
  const auto [before_mm, after_mm] = validated_mm(result);
  model.validation_before_mm = before_mm;
  model.validation_after_mm = after_mm;
  return model;
}

}  // namespace truepose::daemon
