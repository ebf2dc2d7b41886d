#include "daemon/cell/campaign_archive.hpp"

#include <algorithm>
#include <cstdint>
#include <sstream>
#include <utility>

#include "config/frame_file.hpp"
#include "config/measurement_file.hpp"
#include "daemon/campaign/campaign_past.hpp"
#include "daemon/cell/file_part.hpp"
#include "proto/control/json_text.hpp"
#include "proto/record/arm_document.hpp"
#include "proto/record/frame_document.hpp"
#include "proto/record/json_io.hpp"

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
      .id = read.id("id").value_or(""),
      .offset = static_cast<std::size_t>(read.integer("points_offset", 0, kMostPoints).value_or(0)),
      .limit = static_cast<std::size_t>(read.integer("points_limit", 0, most).value_or(0))};
  if (auto wrong = read.finish()) return std::unexpected(*wrong);
  return request;
}

json::array vector_json(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }

json::value id_or_null(const std::string& text) { return text.empty() ? json::value{} : json::value(text); }

}  // namespace

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
          {"model_id", id_or_null(record.model_id)},
          {"by", id_or_null(record.started_by)},
          {"note", record.note},
          {"points_of", id_or_null(record.points_of)}};
}

json::object seen_json(const StoredPoint& point) {
  json::object seen{{"pose", point.pose},
                    {"purpose", purpose_name(point.purpose)},
                    {"smr", point.smr},
                    {"p_mm", point.p_WS_mm ? vector_json(*point.p_WS_mm) : json::value{}},
                    {"std_mm", point.p_WS_mm ? vector_json(point.std_mm) : json::value{}}};
  if (!point.orientation) return seen;
  seen["abc_deg"] = vector_json(kuka_abc_deg(point.orientation->R_WT));
  seen["std_abc_deg"] = point.orientation->sigma_rad * kDegPerRad;
  return seen;
}

namespace {

json::object point_json(const RobotModel& robot, const StoredPoint& point) {
  json::object document = seen_json(point);
  document["q_target_deg"] = record::joints_json(point.q_target, robot);
  document["q_commanded_deg"] = record::joints_json(point.q_commanded, robot);
  document["q_actual_deg"] = record::joints_json(point.q_actual, robot);
  document["time"] = point.time;
  return document;
}

// What leaves room in a line for the rest of an answer; the ends of lines take two bytes each in JSON.
constexpr std::size_t kMostBytes = 48 * 1024;

/// A part of a campaign's points.
struct PointsPage {
  json::value content;  ///< a list of points, or lines of CSV
  std::size_t count = 0, total = 0;
};

/// As many of some points as fit into a line.
PointsPage points_of(json::array points, std::size_t total) {
  json::array page;
  std::size_t bytes = 0;
  for (json::value& point : points) {
    bytes += control::json_text(point).size() + 1;
    if (bytes > kMostBytes) break;
    page.push_back(std::move(point));
  }
  const std::size_t count = page.size();
  return {std::move(page), count, total};
}

/// A file line by line, the header first.
std::vector<std::string> rows_of_file(const std::string& text) {
  std::istringstream file{text};
  std::vector<std::string> rows;
  for (std::string row; std::getline(file, row);) rows.push_back(row + "\n");
  return rows;
}

/// As many rows as fit into a line. The first page has the header too.
PointsPage rows_of(const std::vector<std::string>& rows, std::size_t offset, std::size_t limit) {
  PointsPage page{.content = {}, .total = rows.size() - 1};
  std::string csv = offset == 0 ? rows.front() : "";
  for (std::size_t i = offset + 1; i < rows.size() && page.count < limit; ++i, ++page.count) {
    if (csv.size() + rows[i].size() > kMostBytes) break;
    csv += rows[i];
  }
  page.content = std::move(csv);
  return page;
}

json::array points_json(const std::vector<StoredPoint>& points, const RobotModel& robot, std::size_t offset,
                        std::size_t limit) {
  json::array page;
  for (std::size_t i = offset; i < points.size() && page.size() < limit; ++i)
    page.push_back(point_json(robot, points[i]));
  return page;
}

/// The answer of campaign.points.
/// @param format  "json" or "csv"
MethodResult page_answer(const StoredCampaign& campaign, const RobotModel& robot, const std::string& format,
                         std::size_t offset, std::size_t limit) {
  const bool as_csv = format == "csv";
  PointsPage page =
      as_csv ? rows_of(rows_of_file(measurements_csv(campaign, robot)), offset, limit)
             : points_of(points_json(campaign.points, robot, offset, limit), campaign.points.size());
  if (as_csv && page.total == 0)
    return std::unexpected(RpcError{
        ErrorCode::NotFound, "the campaign has no points that identify or validate; ask for format json"});
  const std::size_t end = offset + page.count;
  json::object answer{{"id", campaign.record.id},
                      {"format", format},
                      {"offset", offset},
                      {"next", end < page.total ? json::value(end) : json::value{}},
                      {"total", page.total}};
  answer[as_csv ? "csv" : "points"] = std::move(page.content);
  return answer;
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

bool is_of_frame(const CampaignRecord& record) { return record.kind == "tool" || record.kind == "base"; }

/// The document of a campaign under the kinds that have one here. A calibration's is asked for by report.get.
json::object documents_json(const CampaignRecord& record, bool with_points) {
  json::object documents{{"drift", nullptr}, {"targets", nullptr}, {"iso9283", nullptr}, {"frame", nullptr}};
  // Points and a long document do not fit into one line of the protocol.
  const bool fits = !with_points || record.kind == "drift";
  const std::string member = is_of_frame(record) ? "frame" : record.kind;
  if (!fits || !documents.contains(member) || record.document.empty()) return documents;
  if (auto document = control::parse_json(record.document)) documents[member] = *std::move(document);
  return documents;
}

}  // namespace

StoreResult<std::optional<StoredCampaign>> read_campaign(Store& store, const std::string& id) {
  auto record = id.empty() ? store.last_campaign() : store.campaign(id);
  if (!record) return std::unexpected(record.error());
  if (!*record) return std::nullopt;
  auto points = store.points((*record)->id);
  if (!points) return std::unexpected(points.error());
  auto skipped = store.skipped((*record)->id);
  if (!skipped) return std::unexpected(skipped.error());
  const bool of_its_own = (*record)->points_of.empty();
  auto resumptions = store.plans().resumptions(of_its_own ? (*record)->id : (*record)->points_of);
  if (!resumptions) return std::unexpected(resumptions.error());
  return StoredCampaign{**std::move(record), *std::move(points), *std::move(skipped),
                        *std::move(resumptions)};
}

json::object campaign_answer(const StoredCampaign& campaign, const RobotModel& robot, std::size_t offset,
                             std::size_t limit) {
  json::object documents = documents_json(campaign.record, limit > 0);
  return {{"campaign", campaign_json(campaign.record)},
          {"progress", nullptr},
          {"skipped", record::to_json(campaign.skipped)},
          {"interruptions", interruptions_json(campaign.resumptions)},
          {"drift", documents["drift"]},
          {"targets", documents["targets"]},
          {"iso9283", documents["iso9283"]},
          {"frame", documents["frame"]},
          {"points_total", campaign.points.size()},
          {"points", points_json(campaign.points, robot, offset, limit)}};
}

std::expected<CampaignRecord, RpcError> report_record(Store& store, const std::string& id) {
  auto found = id.empty() ? store.last_calibration() : store.campaign(id);
  if (!found) return std::unexpected(store_unusable(found.error()));
  if (!*found || (*found)->document.empty() || (*found)->kind != "calibration")
    return std::unexpected(RpcError{ErrorCode::NotFound, "no such campaign, or it has no report"});
  return **std::move(found);
}

std::expected<json::object, RpcError> report_answer(const CampaignRecord& record, std::size_t offset,
                                                    std::size_t limit) {
  auto document = control::parse_json(record.document);
  if (!document)
    return std::unexpected(RpcError{ErrorCode::Internal, "the stored document: " + document.error()});
  const std::size_t total = page_points(document->as_object(), offset, limit);
  return json::object{{"id", record.id}, {"document", *std::move(document)}, {"points_total", total}};
}

namespace {

/// The points of a tool that was measured, with their coordinates where those were stated.
std::vector<FramePoint> points_of_frame(const CampaignRecord& record) {
  std::vector<FramePoint> points;
  const auto json = control::parse_json(record.document);
  if (!json) return points;  // it is not done
  const auto document = record::read_frame_document(*json);
  if (!document) return points;
  for (const record::FrameDocument::Point& point : document->points)
    points.push_back({point.name, point.p_mm});
  return points;
}

}  // namespace

std::string measurements_csv(const StoredCampaign& campaign, const RobotModel& robot) {
  std::vector<StoredPoint> points = campaign.points;
  for (StoredPoint& point : points) point = in_first_frame(std::move(point), campaign.resumptions);
  std::ostringstream text;
  if (is_of_frame(campaign.record)) {
    const auto readings = campaign.record.kind == "base" ? readings_of_base : frame_readings;
    config::write_frame_readings(text, readings(points, points_of_frame(campaign.record)), robot);
  } else {
    config::write_measurements(text, measurement_data(points, {}), robot);
  }
  return text.str();
}

std::vector<Method<CampaignArchive>> CampaignArchive::methods() {
  return {{"campaign.list", &CampaignArchive::list},
          {"campaign.get", &CampaignArchive::get},
          {"campaign.points", &CampaignArchive::points},
          {"campaign.export", &CampaignArchive::measurements},
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

MethodReply CampaignArchive::get(json::object params) {
  const auto request = points_request(params, kMostStoredPoints);
  if (!request) co_return std::unexpected(request.error());
  const auto before = current_();
  const std::string wanted =
      request->id.empty() && before && before->running ? before->record.id : request->id;
  auto job = [this, wanted] { return read_campaign(parts_.store, wanted); };
  auto read = co_await parts_.store_thread.ask(job);
  if (!read) co_return std::unexpected(store_unusable(read.error()));
  StoredCampaign found = read->value_or(StoredCampaign{});
  // It may have ended since it was read.
  const auto current = current_();
  const bool is_current = current && current->record.id == wanted;
  if (is_current) found.record = current->record;
  if (!*read && !is_current) co_return std::unexpected(RpcError{ErrorCode::NotFound, "no such campaign"});
  json::object answer = campaign_answer(found, parts_.config.robot.model, request->offset, request->limit);
  if (current && current->running && current->record.id == found.record.id)
    answer["progress"] = current->progress;
  co_return answer;
}

/// Of a stored campaign, read and made by the store's thread: writing the whole file again for each part
/// takes this thread a few milliseconds only.
MethodReply CampaignArchive::answer_of(std::string id,
                                       std::function<MethodResult(const StoredCampaign&)> make) {
  auto job = [this, id, make]() -> MethodResult {
    const auto found = read_campaign(parts_.store, id);
    if (!found) return std::unexpected(store_unusable(found.error()));
    if (!*found) return std::unexpected(RpcError{ErrorCode::NotFound, "no such campaign"});
    return make(**found);
  };
  auto answer = co_await parts_.store_thread.ask(job);
  co_return answer;
}

MethodReply CampaignArchive::measurements(json::object params) {
  ParamReader reader{params};
  const std::string id = reader.id("id").value_or("");
  const auto offset = static_cast<std::size_t>(reader.integer("offset", 0, INT64_MAX).value_or(0));
  if (auto wrong = reader.finish()) co_return std::unexpected(*wrong);
  auto make = [this, offset](const StoredCampaign& found) -> MethodResult {
    const std::string csv = measurements_csv(found, parts_.config.robot.model);
    return json::object{{"id", found.record.id},
                        {"offset", offset},
                        {"data", csv.substr(std::min(offset, csv.size()), kPart)}};
  };
  auto answer = co_await answer_of(id, make);
  co_return answer;
}

MethodReply CampaignArchive::points(json::object params) {
  ParamReader reader{params};
  std::string id = reader.id("id").value_or("");
  const std::string format = reader.text("format").value_or("json");
  const auto offset = static_cast<std::size_t>(reader.integer("offset", 0, kMostPoints).value_or(0));
  const auto limit = static_cast<std::size_t>(reader.integer("limit", 1, 1000).value_or(1000));
  if (format != "json" && format != "csv") reader.fail("format", "expected json or csv");
  if (auto wrong = reader.finish()) co_return std::unexpected(*wrong);
  const auto current = current_();
  if (id.empty() && current && current->running) id = current->record.id;
  auto make = [this, format, offset, limit](const StoredCampaign& found) {
    return page_answer(found, parts_.config.robot.model, format, offset, limit);
  };
  auto answer = co_await answer_of(id, make);
  co_return answer;
}

MethodReply CampaignArchive::report(json::object params) {
  const auto request = points_request(params, kMostDocumentPoints);
  if (!request) co_return std::unexpected(request.error());
  auto job = [this, id = request->id] { return report_record(parts_.store, id); };
  auto found = co_await parts_.store_thread.ask(job);
  if (!found) co_return std::unexpected(found.error());
  auto answer = report_answer(*found, request->offset, request->limit);
  if (!answer) co_return std::unexpected(answer.error());
  co_return *std::move(answer);
}

}  // namespace truepose::daemon
