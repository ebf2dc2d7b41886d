#include "daemon/cell/identification_service.hpp"

#include <algorithm>
#include <chrono>
#include <utility>

#include "config/cell_setup.hpp"
#include "daemon/campaign/identification.hpp"
#include "daemon/cell/busy.hpp"
#include "daemon/log/log.hpp"
#include "proto/record/calibration_document.hpp"

namespace truepose::daemon {

namespace asio = boost::asio;
using control::ErrorCode;
using control::RpcError;

namespace {

/// Where no pose was measured to validate, so many of those that were measured identify.
constexpr double kUsualSplit = 0.7;

/// The cell's configuration with the options that were asked for.
config::CellConfig with_options(config::CellConfig config, const rpc::CampaignIdentify& asked) {
  config::CalibrationConfig& options = config.calibration;
  options.non_geometric = asked.non_geometric.value_or(options.non_geometric);
  options.harmonics = asked.harmonics.value_or(options.harmonics);
  options.field = asked.residual.value_or(options.field);
  options.loss = asked.loss.value_or(options.loss);
  options.prior = asked.prior.value_or(options.prior);
  config::CampaignConfig& campaign = config.campaign;
  campaign.correct_by_nests = asked.correct_by_nests.value_or(campaign.correct_by_nests);
  campaign.seed = asked.seed.value_or(campaign.seed);
  return config;
}

/// Empty: they are of such an arm.
std::string other_arm(const std::vector<StoredPoint>& points, const RobotModel& robot) {
  const bool same = std::ranges::all_of(
      points, [&](const StoredPoint& point) { return point.q_actual.size() == robot.joint_count(); });
  return same ? "" : "its points have other joints than " + robot.name;
}

/// Of the poses that identify.
std::optional<std::string> too_few(const std::vector<StoredPoint>& points, config::CellConfig config) {
  config.campaign.identify_poses = count_poses(points, PointPurpose::Identify);
  return config::too_few_poses(config);
}

std::optional<double> mean_or_none(const std::optional<StageErrors>& stage,
                                   ErrorStatistics StageErrors::*of) {
  return stage ? std::optional{((*stage).*of).mean} : std::nullopt;
}

}  // namespace

asio::awaitable<std::expected<IdentificationService::Source, RpcError>> IdentificationService::read(
    std::string id) {
  auto job = [this, id]() -> StoreResult<std::optional<Source>> {
    auto record = parts_.store.campaign(id);
    if (!record) return std::unexpected(record.error());
    if (!*record) return std::nullopt;
    // Of an identification: those that it was made from.
    if (!(*record)->points_of.empty()) record = parts_.store.campaign((*record)->points_of);
    if (!record) return std::unexpected(record.error());
    if (!*record) return std::nullopt;
    auto points = parts_.store.points((*record)->id);
    if (!points) return std::unexpected(points.error());
    auto resumptions = parts_.store.plans().resumptions((*record)->id);
    if (!resumptions) return std::unexpected(resumptions.error());
    return Source{**std::move(record), *std::move(points), *std::move(resumptions)};
  };
  auto found = co_await parts_.store_thread.ask(job);
  if (!found) co_return std::unexpected(store_unusable(found.error()));
  if (!*found) co_return std::unexpected(RpcError{ErrorCode::NotFound, "no such campaign"});
  if ((*found)->record.state == "running")
    co_return std::unexpected(runner_.wrong_state("the campaign is under way; identify once it has ended"));
  co_return **std::move(found);
}

/// Takes long.
std::expected<IdentificationService::Made, std::string> IdentificationService::make(
    const drivers::Clock& clock, Request request, Source source) {
  std::vector<StoredPoint> points = source.points;
  if (const std::string other = other_arm(points, request.config.robot.model); !other.empty())
    return std::unexpected(other);
  Made made;
  const bool none_validates = count_poses(points, PointPurpose::Validate) == 0;
  if (request.asked.split || none_validates) {
    made.validate =
        drawn_to_validate(points, request.asked.split.value_or(kUsualSplit), request.config.campaign.seed);
    assign_validation_set(*made.validate, points);
  }
  if (!request.asked.split && none_validates && too_few(points, request.config)) {
    // Better a model that nothing validates than none.
    made.validate.reset();
    points = source.points;
  }
  if (const auto why = too_few(points, request.config))
    return std::unexpected("of the poses to identify from, " + *why);
  const drivers::TimePoint begun = clock.now();
  auto result = identified(points, request.config, source.resumptions);
  if (!result) return std::unexpected(result.error());
  result->elapsed_s = std::chrono::duration<double>(clock.now() - begun).count();
  const CampaignRecord& record = source.record;
  made.result.identities = {{record.robot_model, record.robot_serial, ""},
                            {record.tracker_model, record.tracker_serial, ""}};
  made.result.points = std::move(points);
  made.result.resumptions = source.resumptions;
  made.result.findings = *std::move(result);
  return made;
}

Reply<rpc::CampaignIdentify> IdentificationService::identify(rpc::CampaignIdentify asked, std::string by) {
  if (busy_) co_return std::unexpected(RpcError{ErrorCode::Busy, "another identification is under way"});
  const Busy busy{busy_};
  auto source = co_await read(asked.id);
  if (!source) co_return std::unexpected(source.error());
  const CampaignRecord record = source->record;
  Request request{asked, with_options(parts_.config, asked)};
  auto job = [&clock = parts_.clock, request, points = *source] { return make(clock, request, points); };
  auto made = co_await parts_.compute_thread.ask(job);
  if (!made)
    co_return std::unexpected(
        runner_.wrong_state("campaign " + record.id + " yields no model: " + made.error()));
  Made model = *std::move(made);
  auto answer = co_await keep(std::move(request), record, std::move(model), std::move(by));
  co_return answer;
}

Reply<rpc::CampaignIdentify> IdentificationService::keep(Request request, CampaignRecord source, Made made,
                                                         std::string by) {
  StoreJournal::Options options{.campaign_id = random_uuid(parts_.random),
                                .model_id = random_uuid(parts_.random),
                                .config = request.config,
                                .activate = request.asked.activate,
                                .started_by = by,
                                .source = source,
                                .validate = made.validate};
  StoreJournal journal{std::move(options), parts_.store, parts_.store_thread, parts_.wall_clock,
                       parts_.clock};
  const auto result = std::make_shared<const CampaignResult>(std::move(made.result));
  auto begun = co_await journal.begin(count_poses(result->points, PointPurpose::Identify));
  if (!begun) co_return std::unexpected(store_unusable(begun.error()));
  auto known = co_await journal.know(result->identities);
  if (!known) co_return std::unexpected(store_unusable(known.error()));
  auto ended = co_await journal.end(result, std::nullopt);
  if (!ended) {
    store_.failed(ended.error());
    co_return std::unexpected(store_unusable(ended.error()));
  }
  const CampaignRecord& record = journal.record();
  log_info("campaign " + source.id + " was identified again, as campaign " + record.id);
  if (!record.reason.empty()) log_warning(record.reason);
  co_await models_.announce_made(record.model_id, journal.activated(), by);
  const auto& found = result->as<CalibrationResult>();
  co_return rpc::CampaignIdentify::Result{
      .id = record.id,
      .points_of = source.id,
      .model_id = record.model_id,
      .activated = journal.activated(),
      .reason = record.reason,
      .identify_poses = count_poses(result->points, PointPurpose::Identify),
      .validate_poses = count_poses(result->points, PointPurpose::Validate),
      .validation_before_mm = mean_or_none(found.calibration.validate, &StageErrors::before),
      .validation_after_mm = mean_or_none(found.calibration.validate, &StageErrors::after),
      .verdict = record::verdict_json(found.verdict)};
}

}  // namespace truepose::daemon
