#include "daemon/campaign/store_journal.hpp"

#include <algorithm>
#include <boost/json/array.hpp>
#include <boost/json/object.hpp>
#include <utility>
#include <vector>

#include "config/cell_setup.hpp"
#include "config/model_file.hpp"
#include "core/compensate/largest_correction.hpp"
#include "core/math/units.hpp"
#include "daemon/campaign/conditions_document.hpp"
#include "daemon/campaign/proof_documents.hpp"
#include "daemon/campaign/stored_model.hpp"
#include "proto/control/json_text.hpp"
#include "proto/record/calibration_document.hpp"
#include "proto/record/drift_document.hpp"

namespace truepose::daemon {

namespace asio = boost::asio;

namespace {

namespace json = boost::json;

/// Errors of the points measured again (wanted minus measured, as in "points"), with the numbers that the
/// document gives to their validation poses.
json::array remeasured_points(const CampaignResult& result) {
  std::vector<const StoredPoint*> first;  // in the order in which the document numbers them from 1
  for (const StoredPoint& point : result.points) {
    if (point.purpose == PointPurpose::Identify || point.purpose == PointPurpose::Validate)
      first.push_back(&point);
  }
  json::array points;
  std::size_t k = 0;
  for (const StoredPoint& point : result.points) {
    if (point.purpose != PointPurpose::Remeasure) continue;
    const Eigen::Vector3d error = -result.remeasured_errors_mm[k++];
    const auto before = std::ranges::find_if(first, [&](const StoredPoint* other) {
      return other->purpose == PointPurpose::Validate && other->q_target == point.q_target;
    });
    if (before == first.end()) continue;  // never measured for validation: nothing to show it beside
    points.push_back(json::object{{"pose", before - first.begin() + 1},
                                  {"smr", point.smr},
                                  {"error", {error.x(), error.y(), error.z()}}});
  }
  return points;
}

/// What was identified and validated from, with the times of the points.
MeasurementData timed(const CampaignResult& result, const std::map<int, std::string>& times) {
  MeasurementData data = result.data;
  std::size_t i = 0;
  for (const StoredPoint& point : result.points) {
    if (point.purpose != PointPurpose::Identify && point.purpose != PointPurpose::Validate) continue;
    data.points[i++].time = times.at(point.pose);
  }
  return data;
}

/// The document that reports are made of: that of the calibration, what measuring again has shown, and how it
/// was measured; or that of the other kinds.
std::string document_of(const CampaignResult& result, const CampaignRecord& record,
                        const config::CellConfig& config, const std::map<int, std::string>& times) {
  const MeasurementData data = timed(result, times);
  if (result.drift)
    return control::json_text(record::drift_document(*result.drift, *result.drift_reference, data.points));
  if (result.targets) return control::json_text(targets_document(*result.targets, config.robot.model));
  if (result.iso9283) return control::json_text(iso9283_campaign_document(*result.iso9283));
  json::object document = record::calibration_document(result.calibration, data, result.elapsed_s);
  document["campaign"] = "Campaign " + record.id.substr(0, 8);
  document["robot"] = record.robot_model + ", serial " + record.robot_serial;
  document["tracker"] = record.tracker_model + ", serial " + record.tracker_serial;
  document["model"] = record.model_id;
  document["date"] = record.ended;
  document["options"] = options_document(config);
  document["noise"] = record::noise_json(*config::calibrate_options(config).noise);
  document["conditions"] = conditions_document(result, record);
  document["skipped"] = skipped_document(result);
  if (result.remeasured) {
    document["remeasured"] = record::statistics_json(*result.remeasured);
    document["remeasured_points"] = remeasured_points(result);
  }
  if (!result.reference_drift_mm.empty()) {
    document["reference_drift_mm"] =
        json::array(result.reference_drift_mm.begin(), result.reference_drift_mm.end());
  }
  return control::json_text(document);
}

std::string why_not_activated(const CampaignResult& result) {
  std::string text = "the model was not activated: ";
  if (!result.improves) return text + "it is no better than the nominal arm on validation poses";
  for (const std::string& doubt : result.doubts) text += doubt + "; ";
  return text + "look into that and identify again, or activate it by hand";
}

}  // namespace

StoreJournal::StoreJournal(Options options, Store& store, Worker& store_thread, WallClock wall_clock)
    : options_{std::move(options)},
      store_{store},
      store_thread_{store_thread},
      wall_clock_{std::move(wall_clock)} {
  record_.id = options_.campaign_id;
  record_.kind = kind_name(options_.kind);
  record_.state = "running";
  record_.started = control::rfc3339(wall_clock_());
}

asio::awaitable<StoreResult<void>> StoreJournal::begin(Identities identities) {
  record_.robot_model = identities.robot.model;
  record_.robot_serial = identities.robot.serial;
  record_.tracker_model = identities.tracker.model;
  record_.tracker_serial = identities.tracker.serial;
  auto job = [this, record = record_] { return store_.begin_campaign(record); };
  auto kept = co_await store_thread_.ask(job);
  co_return kept;
}

asio::awaitable<StoreResult<void>> StoreJournal::add_point(StoredPoint point) {
  point.time = times_[point.pose] = control::rfc3339(wall_clock_());
  auto job = [this, point] { return store_.add_point(options_.campaign_id, point); };
  auto kept = co_await store_thread_.ask(job);
  co_return kept;
}

asio::awaitable<StoreResult<void>> StoreJournal::add_skipped(SkippedPose skipped) {
  auto job = [this, skipped] { return store_.add_skipped(options_.campaign_id, skipped); };
  auto kept = co_await store_thread_.ask(job);
  co_return kept;
}

asio::awaitable<StoreResult<void>> StoreJournal::end(std::shared_ptr<const CampaignResult> result,
                                                     std::optional<CampaignError> error) {
  record_.ended = control::rfc3339(wall_clock_());
  record_.state = "done";
  if (error) {
    record_.state = error->fault == CampaignFault::Aborted ? "aborted" : "failed";
    record_.reason = error->detail;
  }
  const bool calibrated = result && result->kind == CampaignKind::Calibration;
  const bool activate = calibrated && result->improves && result->doubts.empty() && options_.activate;
  if (calibrated && options_.activate && !activate) record_.reason = why_not_activated(*result);
  if (calibrated) record_.model_id = options_.model_id;
  // There, because making the document takes longer than the event loop may be held.
  auto document = std::make_shared<std::string>();
  auto job = [this, record = record_, times = times_, result, calibrated, activate, document]() mutable {
    std::optional<ModelRecord> model;
    if (result) record.document = *document = document_of(*result, record, options_.config, times);
    if (calibrated) model = model_of(*result, activate);
    return store_.end_campaign(record, model);
  };
  auto kept = co_await store_thread_.ask(job);
  record_.document = *document;
  activated_ = kept && activate;
  co_return kept;
}

ModelRecord StoreJournal::model_of(const CampaignResult& result, bool active) const {
  const auto& validate = result.calibration.validate;
  config::ModelFile file;
  file.name = options_.config.robot.model.name;
  file.serial = result.identities.robot.serial;
  file.created = record_.ended;
  file.cell = result.calibration.cell;
  file.parameters = result.calibration.parameters;
  file.covariance = result.calibration.covariance;
  file.noise = result.noise;
  if (validate) file.validation_mean_mm = validate->after.mean;

  ModelRecord model;
  model.id = options_.model_id;
  model.created = record_.ended;
  model.campaign_id = options_.campaign_id;
  model.robot_serial = file.serial;
  model.yaml = config::model_yaml(file);
  model.active = active;
  model.largest_correction_deg =
      largest_correction(options_.config.robot.model, file.cell, poses_of_task(result.points)) * kDegPerRad;
  if (validate) {
    model.validation_before_mm = validate->before.mean;
    model.validation_after_mm = validate->after.mean;
  }
  return model;
}

}  // namespace truepose::daemon
