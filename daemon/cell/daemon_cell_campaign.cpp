#include <algorithm>

#include "daemon/cell/campaign_run.hpp"
#include "daemon/cell/cell_json.hpp"
#include "daemon/cell/page.hpp"
#include "daemon/log/log.hpp"
#include "proto/control/json_text.hpp"
#include "proto/control/param_reader.hpp"

// The campaign.* methods of campaigns that were started, and what one tells meanwhile.

namespace truepose::daemon {

namespace asio = boost::asio;
namespace json = boost::json;
using control::ErrorCode;
using control::RpcError;
using namespace std::chrono_literals;

namespace {

RpcError store_error(const StoreError& error) { return {ErrorCode::Internal, error.detail}; }

// A line of the protocol has at most 64 KiB, and a point of a document up to 0.7 kilobyte.
constexpr std::int64_t kMostPointsAPage = 50;
constexpr std::int64_t kMostPoints = 1'000'000'000;

/// Leaves of the document's lists of points and poses what lies in the page.
/// @return how many the longest list has
std::size_t page_points(json::object& document, std::size_t offset, std::size_t limit) {
  std::size_t total = 0;
  for (const char* list : {"points", "remeasured_points", "skipped"}) {
    json::value* found = document.if_contains(list);
    if (found == nullptr) continue;
    json::array& points = found->as_array();
    total = std::max(total, points.size());
    const std::size_t begin = std::min(offset, points.size());
    const std::size_t end = std::min(begin + limit, points.size());
    points = json::array(points.begin() + static_cast<std::ptrdiff_t>(begin),
                         points.begin() + static_cast<std::ptrdiff_t>(end));
  }
  return total;
}

/// What the poses of a phase are measured for.
PointPurpose purpose_in(CampaignPhase phase) {
  switch (phase) {
    case CampaignPhase::Identify:
      return PointPurpose::Identify;
    case CampaignPhase::Validate:
      return PointPurpose::Validate;
    case CampaignPhase::Targets:
      return PointPurpose::Target;
    case CampaignPhase::Cycles:
      return PointPurpose::Cycle;
    default:
      return PointPurpose::Remeasure;
  }
}

}  // namespace

asio::awaitable<void> DaemonCell::run_campaign() {
  CampaignRun& run = *campaign_;
  co_await devices_unasked();
  auto outcome = co_await run.campaign.run();
  run.ended = true;
  if (outcome) identities_ = (*outcome)->identities;
  const std::string reason =
      outcome ? "the campaign is done" : "the campaign ended: " + outcome.error().detail;
  outcome ? log_info(reason) : log_warning(reason);
  if (const std::string& why_not = run.journal.record().reason; outcome && !why_not.empty())
    log_warning(why_not);
  if (!outcome && outcome.error().fault == CampaignFault::Store) {
    apply(StoreFailed{"store: " + outcome.error().detail}, reason);
    parts_.events.publish(control::Topic::Campaign, progress_json());
    co_return;
  }
  const std::string made = run.journal.record().model_id;
  if (!made.empty()) {
    auto model = co_await find_model(made);
    if (model) publish_model("made", *model);
    if (run.journal.activated()) {
      auto loaded = co_await load_active_model();
      if (!loaded) log_error(loaded.error().detail);
      if (active_) publish_model("activated", active_->record);
    }
  }
  apply(CampaignEnded{}, reason);
  if (!outcome &&
      (outcome.error().fault == CampaignFault::Device || outcome.error().fault == CampaignFault::WrongArm)) {
    apply(DeviceLost{outcome.error().detail}, reason);
  }
  // Last: who waits for the end may command the cell at once.
  parts_.events.publish(control::Topic::Campaign, progress_json());
}

DaemonCell::Reply DaemonCell::campaign_pause(json::object params) {
  const Result accepted = simple_request(params, CampaignPauseRequested{}, "paused by an operator");
  if (!accepted) co_return accepted;
  co_return progress_json();
}

DaemonCell::Reply DaemonCell::campaign_resume(json::object params) {
  const Result accepted = simple_request(params, CampaignResumeRequested{}, "resumed by an operator");
  if (!accepted) co_return accepted;
  co_return progress_json();
}

DaemonCell::Reply DaemonCell::campaign_abort(json::object params) {
  const Result accepted = simple_request(params, CampaignAbortRequested{}, "aborted by an operator");
  if (!accepted) co_return accepted;
  while (!campaign_->ended) {
    const TimePoint next = parts_.clock.now() + 50ms;
    co_await parts_.clock.sleep_until(next);
  }
  co_return progress_json();
}

DaemonCell::Reply DaemonCell::campaign_list(json::object params) {
  control::ParamReader read{params};
  const Page page{read};
  if (auto wrong = read.finish()) co_return std::unexpected(*wrong);
  auto job = [this] { return parts_.store.campaigns(); };
  auto records = co_await parts_.store_thread.ask(job);
  if (!records) co_return std::unexpected(store_error(records.error()));
  co_return json::object{{"campaigns", page.of(*records, &campaign_json)}, {"total", records->size()}};
}

DaemonCell::Reply DaemonCell::campaign_get(json::object params) {
  control::ParamReader read{params};
  const std::string id = read.text("id").value_or("");
  const auto offset = static_cast<std::size_t>(read.integer("points_offset", 0, 1'000'000'000).value_or(0));
  const auto limit = static_cast<std::size_t>(read.integer("points_limit", 0, 100).value_or(0));
  if (auto wrong = read.finish()) co_return std::unexpected(*wrong);

  struct Found {
    std::optional<CampaignRecord> record;
    std::vector<StoredPoint> points;
    std::vector<SkippedPose> skipped;
  };
  const std::string wanted = id.empty() && campaign_ && !campaign_->ended ? campaign_->id : id;
  auto job = [this, wanted]() -> StoreResult<Found> {
    Found found;
    auto all = parts_.store.campaigns();
    if (!all) return std::unexpected(all.error());
    for (const CampaignRecord& record : *all) {
      if (wanted.empty() || record.id == wanted) {
        found.record = record;
        break;
      }
    }
    if (!found.record) return found;
    if (found.record->kind != "calibration") {  // with its document, which is small
      const auto whole = parts_.store.campaign(found.record->id);
      if (!whole) return std::unexpected(whole.error());
      if (*whole) found.record = **whole;
    }
    auto points = parts_.store.points(found.record->id);
    if (!points) return std::unexpected(points.error());
    auto skipped = parts_.store.skipped(found.record->id);
    if (!skipped) return std::unexpected(skipped.error());
    found.points = *std::move(points);
    found.skipped = *std::move(skipped);
    return found;
  };
  auto found = co_await parts_.store_thread.ask(job);
  if (!found) co_return std::unexpected(store_error(found.error()));
  // The campaign of now is not in the store before its devices are known, and may have ended since it was
  // read.
  if (campaign_ && campaign_->id == wanted) found->record = campaign_->journal.record();
  if (!found->record) co_return std::unexpected(RpcError{ErrorCode::NotFound, "no such campaign"});
  json::array skipped;
  for (const SkippedPose& pose : found->skipped) skipped.push_back(skipped_json(pose));
  json::array points;
  for (std::size_t i = offset; i < found->points.size() && points.size() < limit; ++i) {
    points.push_back(point_json(parts_.config.robot.model, found->points[i]));
  }
  json::object documents{{"drift", nullptr}, {"targets", nullptr}, {"iso9283", nullptr}};
  // Points and a long document do not fit into one line of the protocol.
  const bool fits = limit == 0 || found->record->kind == "drift";
  if (fits && documents.contains(found->record->kind) && !found->record->document.empty()) {
    if (auto document = control::parse_json(found->record->document))
      documents[found->record->kind] = *std::move(document);
  }
  const bool running = campaign_ && !campaign_->ended && campaign_->id == found->record->id;
  co_return json::object{{"campaign", campaign_json(*found->record)},
                         {"progress", running ? json::value(progress_json()) : json::value{}},
                         {"skipped", std::move(skipped)},
                         {"drift", documents["drift"]},
                         {"targets", documents["targets"]},
                         {"iso9283", documents["iso9283"]},
                         {"points_total", found->points.size()},
                         {"points", std::move(points)}};
}

DaemonCell::Reply DaemonCell::report_get(json::object params) {
  control::ParamReader read{params};
  const std::string id = read.text("id").value_or("");
  const auto offset = static_cast<std::size_t>(read.integer("points_offset", 0, kMostPoints).value_or(0));
  const auto limit = static_cast<std::size_t>(read.integer("points_limit", 0, kMostPointsAPage).value_or(0));
  if (auto wrong = read.finish()) co_return std::unexpected(*wrong);
  auto job = [this, id]() -> StoreResult<std::optional<CampaignRecord>> {
    if (!id.empty()) return parts_.store.campaign(id);
    auto all = parts_.store.campaigns();
    if (!all) return std::unexpected(all.error());
    for (const CampaignRecord& record : *all) {
      if (record.state == "done" && record.kind == "calibration") return parts_.store.campaign(record.id);
    }
    return std::nullopt;
  };
  auto record = co_await parts_.store_thread.ask(job);
  if (!record) co_return std::unexpected(store_error(record.error()));
  if (!*record || (*record)->document.empty() || (*record)->kind != "calibration") {
    co_return std::unexpected(RpcError{ErrorCode::NotFound, "no such campaign, or it has no report"});
  }
  auto document = control::parse_json((*record)->document);
  if (!document)
    co_return std::unexpected(RpcError{ErrorCode::Internal, "the stored document: " + document.error()});
  const std::size_t total = page_points(document->as_object(), offset, limit);
  co_return json::object{{"id", (*record)->id}, {"document", *std::move(document)}, {"points_total", total}};
}

void DaemonCell::on_progress(const CampaignProgress&) {
  parts_.events.publish(control::Topic::Campaign, progress_json());
}

void DaemonCell::on_point(const StoredPoint& point, double deviation_mm, const CampaignProgress& progress) {
  parts_.events.publish(
      control::Topic::Measurement,
      json::object{{"campaign_id", campaign_->id},
                   {"pose", point.pose},
                   {"purpose", purpose_name(point.purpose)},
                   {"smr", point.smr},
                   {"p_mm", vector_json(point.p_WS_mm)},
                   {"std_mm", vector_json(point.std_mm)},
                   {"error_mm", progress.error_mm ? json::value(deviation_mm) : json::value{}},
                   {"reason", ""}});
  on_progress(progress);
}

void DaemonCell::on_skipped(const SkippedPose& skipped, const CampaignProgress& progress) {
  log_warning("pose " + std::to_string(skipped.pose) + " skipped: " + skipped.reason);
  parts_.events.publish(control::Topic::Measurement,
                        json::object{{"campaign_id", campaign_->id},
                                     {"pose", skipped.pose},
                                     {"purpose", purpose_name(purpose_in(progress.phase))},
                                     {"smr", parts_.config.reflector.name},
                                     {"p_mm", nullptr},
                                     {"std_mm", nullptr},
                                     {"error_mm", nullptr},
                                     {"reason", skipped.reason}});
  on_progress(progress);
}

void DaemonCell::on_trouble(const std::string& sentence) { log_warning(sentence); }

json::object DaemonCell::progress_json() const {
  const CampaignProgress& progress = campaign_->campaign.progress();
  const CampaignRecord& record = campaign_->journal.record();
  std::string_view phase = phase_name(progress.phase);
  if (campaign_->ended)
    phase = record.state;
  else if (std::holds_alternative<Paused>(state_))
    phase = "paused";
  return {{"id", campaign_->id},
          {"phase", phase},
          {"done", progress.done},
          {"total", progress.total},
          {"error_mm", progress.error_mm ? json::value(*progress.error_mm) : json::value{}},
          {"eta_s", progress.time_left_s ? json::value(*progress.time_left_s) : json::value{}},
          {"skipped", progress.skipped},
          {"reason", record.reason},
          {"model_id", record.model_id.empty() ? json::value{} : json::value(record.model_id)}};
}

}  // namespace truepose::daemon
