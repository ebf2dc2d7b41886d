#include "daemon/cell/campaign_archive.hpp"

#include <algorithm>
#include <cstdint>
#include <sstream>
#include <utility>

#include "config/frame_file.hpp"
#include "config/measurement_file.hpp"
#include "core/arm/joint_units.hpp"
#include "daemon/campaign/campaign_past.hpp"
#include "daemon/cell/file_part.hpp"
#include "proto/control/json_text.hpp"
#include "proto/record/frame_document.hpp"
#include "proto/record/json_io.hpp"

namespace truepose::daemon {

namespace json = boost::json;
using control::ErrorCode;
using control::RpcError;

namespace {}  // namespace

rpc::CampaignSummary campaign_summary(const CampaignRecord& record) {
  return {.id = record.id,
          .kind = record.kind,
          .started = record.started,
          .ended = text_or_none(record.ended),
          .state = record.state,
          .reason = record.reason,
          .robot_model = record.robot_model,
          .robot_serial = record.robot_serial,
          .tracker_model = record.tracker_model,
          .tracker_serial = record.tracker_serial,
          .by = text_or_none(record.started_by),
          .note = record.note,
          .model_id = text_or_none(record.model_id),
          .points_of = text_or_none(record.points_of)};
}

rpc::SeenPoint seen_point(const StoredPoint& point) {
  rpc::SeenPoint seen{.pose = point.pose,
                      .purpose = std::string{purpose_name(point.purpose)},
                      .smr = point.smr,
                      .p_mm = point.p_WS_mm};
  if (point.p_WS_mm) seen.std_mm = point.std_mm;
  if (!point.orientation) return seen;
  seen.abc_deg = kuka_abc_deg(point.orientation->R_WT);
  seen.std_abc_deg = point.orientation->sigma_rad * kDegPerRad;
  return seen;
}

namespace {

rpc::Point point_of(const RobotModel& robot, const StoredPoint& point) {
  rpc::Point x{seen_point(point)};
  x.q_target_deg = in_deg_mm(point.q_target, robot);
  x.q_commanded_deg = in_deg_mm(point.q_commanded, robot);
  x.q_actual_deg = in_deg_mm(point.q_actual, robot);
  x.time = point.time;
  return x;
}

std::vector<rpc::Point> points_of(const StoredCampaign& campaign, const RobotModel& robot, std::size_t offset,
                                  std::size_t limit) {
  std::vector<rpc::Point> page;
  for (std::size_t i = offset; i < campaign.points.size() && page.size() < limit; ++i)
    page.push_back(point_of(robot, campaign.points[i]));
  return page;
}

// What leaves room in a line for the rest of an answer; the ends of lines take two bytes each in JSON.
constexpr std::size_t kMostBytes = 48 * 1024;

/// As many of some points as fit into a line.
std::vector<rpc::Point> fitting(std::vector<rpc::Point> points) {
  std::size_t bytes = 0;
  const auto does_not_fit = [&bytes](const rpc::Point& point) {
    bytes += control::json_text(record::to_json(point)).size() + 1;
    return bytes > kMostBytes;
  };
  points.erase(std::ranges::find_if(points, does_not_fit), points.end());
  return points;
}

/// A file line by line, the header first.
std::vector<std::string> rows_of_file(const std::string& text) {
  std::istringstream file{text};
  std::vector<std::string> rows;
  for (std::string row; std::getline(file, row);) rows.push_back(row + "\n");
  return rows;
}

/// As many rows as fit into a line. The first page has the header too.
/// @return how many
std::size_t append_rows(const std::vector<std::string>& rows, std::size_t offset, std::size_t limit,
                        std::string& csv) {
  if (offset == 0) csv = rows.front();
  std::size_t count = 0;
  for (std::size_t i = offset + 1; i < rows.size() && count < limit; ++i, ++count) {
    if (csv.size() + rows[i].size() > kMostBytes) break;
    csv += rows[i];
  }
  return count;
}

Answer<rpc::CampaignPoints> page_answer(const StoredCampaign& campaign, const RobotModel& robot,
                                        const rpc::CampaignPoints& request) {
  const auto limit = static_cast<std::size_t>(request.limit);
  rpc::CampaignPoints::Result page{
      .id = campaign.record.id, .format = request.format, .offset = request.offset};
  std::size_t end = request.offset, total = campaign.points.size();
  if (request.format == "csv") {
    const std::vector<std::string> rows = rows_of_file(measurements_csv(campaign, robot));
    total = rows.size() - 1;
    if (total == 0)
      return std::unexpected(RpcError{
          ErrorCode::NotFound, "the campaign has no points that identify or validate; ask for format json"});
    end += append_rows(rows, request.offset, limit, page.csv.emplace());
  } else {
    page.points = fitting(points_of(campaign, robot, request.offset, limit));
    end += page.points->size();
  }
  if (end < total) page.next = end;
  page.total = static_cast<int>(total);
  return page;
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

/// Puts the document of a campaign under its kind, where that has one here. A calibration's is asked for by
/// report.get.
void add_document(const CampaignRecord& record, bool with_points, rpc::CampaignGet::Result& answer) {
  // Points and a long document do not fit into one line of the protocol.
  if (record.document.empty() || (with_points && record.kind != "drift")) return;
  json::value* const member = record.kind == "drift"     ? &answer.drift
                              : record.kind == "targets" ? &answer.targets
                              : record.kind == "iso9283" ? &answer.iso9283
                              : is_of_frame(record)      ? &answer.frame
                                                         : nullptr;
  if (member == nullptr) return;
  if (auto document = control::parse_json(record.document)) *member = *std::move(document);
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

rpc::CampaignGet::Result campaign_answer(const StoredCampaign& campaign, const RobotModel& robot,
                                         std::size_t offset, std::size_t limit) {
  rpc::CampaignGet::Result answer{.campaign = campaign_summary(campaign.record),
                                  .skipped = campaign.skipped,
                                  .interruptions = {campaign.resumptions.begin(), campaign.resumptions.end()},
                                  .points_total = campaign.points.size(),
                                  .points = points_of(campaign, robot, offset, limit)};
  add_document(campaign.record, limit > 0, answer);
  return answer;
}

std::expected<CampaignRecord, RpcError> report_record(Store& store, const std::string& id) {
  auto found = id.empty() ? store.last_calibration() : store.campaign(id);
  if (!found) return std::unexpected(store_unusable(found.error()));
  if (!*found || (*found)->document.empty() || (*found)->kind != "calibration")
    return std::unexpected(RpcError{ErrorCode::NotFound, "no such campaign, or it has no report"});
  return **std::move(found);
}

Answer<rpc::ReportGet> report_answer(const CampaignRecord& record, std::size_t offset, std::size_t limit) {
  auto document = control::parse_json(record.document);
  if (!document)
    return std::unexpected(RpcError{ErrorCode::Internal, "the stored document: " + document.error()});
  json::object& page = document->as_object();
  const std::size_t total = page_points(page, offset, limit);
  return rpc::ReportGet::Result{.id = record.id, .document = std::move(page), .points_total = total};
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

std::vector<Served<CampaignArchive>> CampaignArchive::methods() {
  return {&CampaignArchive::list, &CampaignArchive::get, &CampaignArchive::points,
          &CampaignArchive::measurements, &CampaignArchive::report};
}

Reply<rpc::CampaignList> CampaignArchive::list(rpc::CampaignList request) {
  auto job = [this] { return parts_.store.campaigns(); };
  auto records = co_await parts_.store_thread.ask(job);
  if (!records) co_return std::unexpected(store_unusable(records.error()));
  co_return rpc::CampaignList::Result{.campaigns = page_of(*records, request, &campaign_summary),
                                      .total = static_cast<int>(records->size())};
}

Reply<rpc::CampaignGet> CampaignArchive::get(rpc::CampaignGet request) {
  const auto before = current_();
  std::string wanted = request.id.value_or("");
  if (wanted.empty() && before && before->running) wanted = before->record.id;
  auto job = [this, wanted] { return read_campaign(parts_.store, wanted); };
  auto read = co_await parts_.store_thread.ask(job);
  if (!read) co_return std::unexpected(store_unusable(read.error()));
  StoredCampaign found = read->value_or(StoredCampaign{});
  // It may have ended since it was read.
  const auto current = current_();
  const bool is_current = current && current->record.id == wanted;
  if (is_current) found.record = current->record;
  if (!*read && !is_current) co_return std::unexpected(RpcError{ErrorCode::NotFound, "no such campaign"});
  auto answer = campaign_answer(found, parts_.config.robot.model, request.points_offset,
                                static_cast<std::size_t>(request.points_limit));
  if (current && current->running && current->record.id == found.record.id)
    answer.progress = current->progress;
  co_return answer;
}

/// Of a stored campaign, read and made by the store's thread: writing the whole file again for each part
/// takes this thread a few milliseconds only.
template <rpc::Request R>
Reply<R> CampaignArchive::answer_of(std::string id, std::function<Answer<R>(const StoredCampaign&)> make) {
  auto job = [this, id, make]() -> Answer<R> {
    const auto found = read_campaign(parts_.store, id);
    if (!found) return std::unexpected(store_unusable(found.error()));
    if (!*found) return std::unexpected(RpcError{ErrorCode::NotFound, "no such campaign"});
    return make(**found);
  };
  auto answer = co_await parts_.store_thread.ask(job);
  co_return answer;
}

Reply<rpc::CampaignExport> CampaignArchive::measurements(rpc::CampaignExport request) {
  auto make = [this, offset = request.offset](const StoredCampaign& found) -> Answer<rpc::CampaignExport> {
    const std::string csv = measurements_csv(found, parts_.config.robot.model);
    return rpc::CampaignExport::Result{.id = found.record.id,
                                       .offset = offset,
                                       .data = csv.substr(std::min<std::size_t>(offset, csv.size()), kPart)};
  };
  auto answer = co_await answer_of<rpc::CampaignExport>(request.id.value_or(""), make);
  co_return answer;
}

Reply<rpc::CampaignPoints> CampaignArchive::points(rpc::CampaignPoints request) {
  const auto current = current_();
  if (!request.id && current && current->running) request.id = current->record.id;
  auto make = [this, request](const StoredCampaign& found) {
    return page_answer(found, parts_.config.robot.model, request);
  };
  auto answer = co_await answer_of<rpc::CampaignPoints>(request.id.value_or(""), make);
  co_return answer;
}

Reply<rpc::ReportGet> CampaignArchive::report(rpc::ReportGet request) {
  auto job = [this, id = request.id.value_or("")] { return report_record(parts_.store, id); };
  auto found = co_await parts_.store_thread.ask(job);
  if (!found) co_return std::unexpected(found.error());
  auto answer = report_answer(*found, request.points_offset, static_cast<std::size_t>(request.points_limit));
  co_return answer;
}

}  // namespace truepose::daemon
