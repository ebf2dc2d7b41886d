#include "daemon/cell/campaign_archive.hpp"

#include <algorithm>
#include <utility>

#include "proto/control/json_text.hpp"
#include "proto/record/arm_document.hpp"

namespace truepose::daemon {

namespace json = boost::json;
using control::ErrorCode;
using control::ParamReader;
using control::RpcError;

namespace {

// A line of the protocol has at most 64 KiB, and a point of a document up to 0.7 kilobyte.
constexpr std::int64_t kMostDocumentPoints = 50;
constexpr std::int64_t kMostStoredPoints = 100;
constexpr std::int64_t kMostPoints = 1'000'000'000;

/// Which campaign, and the part of its points, that a request asks for.
struct PointsRequest {
  std::string id;
  std::size_t offset;
  std::size_t limit;
};

std::expected<PointsRequest, RpcError> points_request(const json::object& params, std::int64_t most) {
  ParamReader read{params};
  PointsRequest request{
      .id = read.text("id").value_or(""),
      .offset = static_cast<std::size_t>(read.integer("points_offset", 0, kMostPoints).value_or(0)),
      .limit = static_cast<std::size_t>(read.integer("points_limit", 0, most).value_or(0))};
  if (auto wrong = read.finish()) return std::unexpected(*wrong);
  return request;
}

json::value id_or_null(const std::string& text) { return text.empty() ? json::value{} : json::value(text); }

json::object campaign_json(const CampaignRecord& record) {
  return {{"id", record.id},
          {"kind", record.kind},
          {"started", record.started},
          {"ended", id_or_null(record.ended)},
          {"state", record.state},
          {"reason", record.reason},
          {"robot_model", record.robot_model},
          {"robot_serial", record.robot_serial},
          {"tracker_model", record.tracker_model},
          {"tracker_serial", record.tracker_serial},
          {"model_id", id_or_null(record.model_id)}};
}

json::object skipped_json(const SkippedPose& skipped) {
  return {{"pose", skipped.pose}, {"reason", skipped.reason}, {"attempts", skipped.attempts}};
}

json::array interruptions_json(const std::vector<Resumption>& resumptions) {
  json::array list;
  for (const Resumption& once : resumptions)
    list.push_back(
        json::object{{"interrupted", once.interrupted}, {"resumed", once.resumed}, {"found", once.found}});
  return list;
}

json::object point_json(const RobotModel& robot, const StoredPoint& point) {
  return {{"pose", point.pose},
          {"purpose", purpose_name(point.purpose)},
          {"smr", point.smr},
          {"q_target_deg", record::joints_json(point.q_target, robot)},
          {"q_commanded_deg", record::joints_json(point.q_commanded, robot)},
          {"q_actual_deg", record::joints_json(point.q_actual, robot)},
          {"p_mm", vector_json(point.p_WS_mm)},
          {"std_mm", vector_json(point.std_mm)},
          {"time", point.time}};
}

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

/// The document of a campaign under the kinds that have one here. A calibration's is asked for by report.get.
json::object documents_json(const CampaignRecord& record, bool with_points) {
  json::object documents{{"drift", nullptr}, {"targets", nullptr}, {"iso9283", nullptr}};
  // Points and a long document do not fit into one line of the protocol.
  const bool fits = !with_points || record.kind == "drift";
  if (!fits || !documents.contains(record.kind) || record.document.empty()) return documents;
  if (auto document = control::parse_json(record.document)) documents[record.kind] = *std::move(document);
  return documents;
}

}  // namespace

json::array vector_json(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }

std::vector<Method<CampaignArchive>> CampaignArchive::methods() {
  return {{"campaign.list", &CampaignArchive::list},
          {"campaign.get", &CampaignArchive::get},
          {"report.get", &CampaignArchive::report}};
}

MethodReply CampaignArchive::list(json::object params) {
  ParamReader reader{params};
  const Page page{reader};
  if (auto wrong = reader.finish()) co_return std::unexpected(*wrong);
  auto job = [this] { return parts_.store.campaigns(); };
  auto records = co_await parts_.store_thread.ask(job);
  if (!records) co_return std::unexpected(store_unusable(records.error()));
  co_return json::object{{"campaigns", page.of(*records, &campaign_json)}, {"total", records->size()}};
}

/// @param id  empty: the last one
StoreResult<CampaignArchive::Found> CampaignArchive::read(const std::string& id) {
  auto record = id.empty() ? parts_.store.last_campaign() : parts_.store.campaign(id);
  if (!record) return std::unexpected(record.error());
  if (!*record) return Found{};
  auto points = parts_.store.points((*record)->id);
  if (!points) return std::unexpected(points.error());
  auto skipped = parts_.store.skipped((*record)->id);
  if (!skipped) return std::unexpected(skipped.error());
  auto resumptions = parts_.store.plans().resumptions((*record)->id);
  if (!resumptions) return std::unexpected(resumptions.error());
  return Found{**std::move(record), *std::move(points), *std::move(skipped), *std::move(resumptions)};
}

json::array CampaignArchive::points_json(const std::vector<StoredPoint>& points, std::size_t offset,
                                         std::size_t limit) const {
  json::array page;
  for (std::size_t i = offset; i < points.size() && page.size() < limit; ++i)
    page.push_back(point_json(parts_.config.robot.model, points[i]));
  return page;
}

MethodReply CampaignArchive::get(json::object params) {
  const auto request = points_request(params, kMostStoredPoints);
  if (!request) co_return std::unexpected(request.error());
  const auto before = current_();
  const std::string wanted =
      request->id.empty() && before && before->running ? before->record.id : request->id;
  auto job = [this, wanted] { return read(wanted); };
  auto found = co_await parts_.store_thread.ask(job);
  if (!found) co_return std::unexpected(store_unusable(found.error()));
  // It may have ended since it was read.
  const auto current = current_();
  if (current && current->record.id == wanted) found->record = current->record;
  if (!found->record) co_return std::unexpected(RpcError{ErrorCode::NotFound, "no such campaign"});
  json::array skipped;
  for (const SkippedPose& pose : found->skipped) skipped.push_back(skipped_json(pose));
  json::object documents = documents_json(*found->record, request->limit > 0);
  const bool running = current && current->running && current->record.id == found->record->id;
  co_return json::object{{"campaign", campaign_json(*found->record)},
                         {"progress", running ? current->progress : json::value{}},
                         {"skipped", std::move(skipped)},
                         {"interruptions", interruptions_json(found->resumptions)},
                         {"drift", documents["drift"]},
                         {"targets", documents["targets"]},
                         {"iso9283", documents["iso9283"]},
                         {"points_total", found->points.size()},
                         {"points", points_json(found->points, request->offset, request->limit)}};
}

MethodReply CampaignArchive::report(json::object params) {
  const auto request = points_request(params, kMostDocumentPoints);
  if (!request) co_return std::unexpected(request.error());
  auto job = [this, id = request->id] {
    return id.empty() ? parts_.store.last_calibration() : parts_.store.campaign(id);
  };
  auto found = co_await parts_.store_thread.ask(job);
  if (!found) co_return std::unexpected(store_unusable(found.error()));
  const std::optional<CampaignRecord>& record = *found;
  if (!record || record->document.empty() || record->kind != "calibration")
    co_return std::unexpected(RpcError{ErrorCode::NotFound, "no such campaign, or it has no report"});
  auto document = control::parse_json(record->document);
  if (!document)
    co_return std::unexpected(RpcError{ErrorCode::Internal, "the stored document: " + document.error()});
  const std::size_t total = page_points(document->as_object(), request->offset, request->limit);
  co_return json::object{{"id", record->id}, {"document", *std::move(document)}, {"points_total", total}};
}

}  // namespace truepose::daemon
