#include "tools/truepose/online/campaign_commands.hpp"

#include <boost/json/array.hpp>
#include <boost/json/value.hpp>
#include <boost/json/value_from.hpp>
#include <cstdio>
#include <sstream>
#include <vector>

#include "config/csv_reader.hpp"
#include "config/frame_file.hpp"
#include "config/measurement_file.hpp"
#include "config/target_file.hpp"
#include "config/text_file.hpp"
#include "proto/control/json_text.hpp"
#include "tools/truepose/online/campaign_watch.hpp"
#include "tools/truepose/online/online_text.hpp"
#include "tools/truepose/online/rpc_client.hpp"
#include "tools/truepose/text.hpp"

namespace truepose::tools {
namespace {

namespace json = boost::json;

// ---- Files ----

json::array coordinates(const Eigen::Vector3d& p) { return {p.x(), p.y(), p.z()}; }

/// The joints that were found for targets, CSV: q1..qN, and the last error in residual_mm. Targets without
/// joints are left out.
///
/// @param targets  TargetsDocument of the control protocol
std::string joints_csv(const json::value& targets) {
  std::string header, rows;
  for (const json::value& target : targets.at("targets").as_array()) {
    const json::array& joints = target.at("joints_deg").as_array();
    if (joints.empty()) continue;
    header.clear();
    for (const std::string& name : config::joint_column_names("q", joints.size())) header += name + ",";
    for (const json::value& joint : joints) rows += control::json_text(joint) + ",";
    rows += control::json_text(target.at("errors_mm").as_array().back()) + "\n";
  }
  return header + "residual_mm\n" + rows;
}

/// The cycles of an ISO 9283 test, CSV as `truepose iso9283` reads it: points in the tracker's frame, where
/// they were commanded in the robot's base. The rows of several campaigns in one file show the drift.
///
/// @param iso9283  Iso9283Document of the control protocol
/// @param started  of the campaign, which names the series
/// @param points   all points of the campaign
std::string cycles_csv(const json::value& iso9283, const std::string& started, const json::array& points) {
  const json::array& commanded = iso9283.at("commanded").as_array();
  std::string csv = "time,point,cycle,direction,x,y,z,cx,cy,cz\n";
  for (const json::value& point : points) {
    const auto pose = point.at("pose").to_number<std::size_t>() - 1;
    const json::value& asked = commanded[pose % commanded.size()];
    csv += started;
    (csv += ',') += asked.at("point").as_string();
    (csv += ',') += std::to_string(pose / commanded.size() + 1);
    csv += ',';
    if (const json::value* direction = asked.as_object().if_contains("direction"))
      csv += direction->as_string();
    for (const json::value& coordinate : point.at("p_mm").as_array())
      (csv += ',') += control::json_text(coordinate);
    for (const char* axis : {"x", "y", "z"}) (csv += ',') += control::json_text(asked.at(axis));
    csv += '\n';
  }
  return csv;
}

/// All points of a campaign, page by page.
json::array all_points(CampaignSource& source, const std::string& id) {
  json::array points;
  for (;;) {
    const json::object params{
        {"id", id}, {"points_offset", points.size()}, {"points_limit", 50}};  // that surely fit into a line
    const json::value page = source.ask("campaign.get", params);
    const json::array& more = page.at("points").as_array();
    if (more.empty()) return points;
    points.insert(points.end(), more.begin(), more.end());
  }
}

/// The measurement file of a campaign, part by part.
std::string measurements_of(CampaignSource& source, const std::string& id) {
  std::string csv;
  for (;;) {
    const json::value part = source.ask("campaign.export", {{"id", id}, {"offset", csv.size()}});
    const std::string more = string_at(part, "/data");
    if (more.empty()) return csv;
    csv += more;
  }
}

/// @param kind  what the campaign must be to have the document: "targets", "iso9283"
const json::value& document_of(const json::value& campaign, const std::string& kind) {
  const json::value* const document = campaign.as_object().if_contains(kind);
  if (document && !document->is_null()) return *document;
  throw CommandError{kFailed, "campaign " + string_at(campaign, "/campaign/id") + " is not of kind " + kind +
                                  ", or is not done"};
}

/// Of a campaign of any kind.
json::value any_document(CampaignSource& source, const json::value& campaign) {
  const std::string kind = string_at(campaign, "/campaign/kind");
  const bool is_frame = kind == "tool" || kind == "base";
  if (kind != "calibration") return document_of(campaign, is_frame ? "frame" : kind);
  return whole_report(source, string_at(campaign, "/campaign/id"));
}

/// The file of a tool or a base that was measured.
std::string frame_file(const json::value& campaign) {
  const std::string id = string_at(campaign, "/campaign/id");
  if (!find_at(campaign, "/frame"))
    throw CommandError{kFailed, "campaign " + id + " measured no tool and no base, or is not done"};
  std::string yaml = string_at(campaign, "/frame/yaml");
  if (yaml.empty())
    throw CommandError{kFailed, "campaign " + id + ": " + string_at(campaign, "/campaign/reason")};
  return yaml;
}

/// All of them, or none.
void write_files(CampaignSource& source, const json::value& campaign, const CampaignFiles& files) {
  const std::string id = string_at(campaign, "/campaign/id");
  std::vector<config::TextFile> made;
  if (!files.data.empty()) made.push_back({files.data, measurements_of(source, id)});
  if (!files.joints.empty()) made.push_back({files.joints, joints_csv(document_of(campaign, "targets"))});
  if (!files.cycles.empty()) {
    const json::value& iso9283 = document_of(campaign, "iso9283");
    made.push_back({files.cycles,
                    cycles_csv(iso9283, string_at(campaign, "/campaign/started"), all_points(source, id))});
  }
  if (!files.frame.empty()) made.push_back({files.frame, frame_file(campaign)});
  if (!files.document.empty())
    made.push_back({files.document, control::json_text(any_document(source, campaign)) + "\n"});
  config::write_together(made);
}

// ---- Progress ----

RpcClient connect_for_campaign(const OnlineOptions& online) {
  RpcClient client = value_or_throw(RpcClient::connect(online));
  // Before anything else, so that no event is missed.
  subscribe_to_watch(client);
  return client;
}

/// Follows a campaign whose events this client already gets.
int follow(RpcClient& client, const OnlineOptions& online, const json::object& params) {
  const json::value present = value_or_throw(client.call("campaign.get", params));
  const json::value* const begun = find_at(present, "/progress");
  if (!begun) {  // over already
    print(online, present, campaign_text);
    return string_at(present, "/campaign/state") == "done" ? kDone : kFailed;
  }
  const json::value progress = watch_to_end(client, string_at(present, "/campaign/id"), *begun, online.json);
  print(online.json ? control::json_text(progress) + "\n" : ending_text(client, progress));
  return string_at(progress, "/phase") == "done" ? kDone : kFailed;
}

}  // namespace

json::object targets_of_file(const std::filesystem::path& file) {
  std::istringstream in{config::read_text_file(file, config::CsvTable::kMostBytes)};
  config::TargetReader reader{in, file.string(), {}};
  json::array rows;
  while (const auto row = reader.next()) rows.push_back(json::value_from(row->numbers));
  return {{reader.form() == config::TargetForm::Joints ? "joints" : "poses", std::move(rows)}};
}

json::object points_of_file(const std::filesystem::path& file) {
  json::array names, at, known;
  for (const config::PlannedPoint& point : config::load_points(file)) {
    names.emplace_back(point.name);
    if (point.at_mm) at.push_back(coordinates(*point.at_mm));
    if (point.known_mm) known.push_back(coordinates(*point.known_mm));
  }
  json::object points{{"points", std::move(names)}};
  if (!at.empty()) points["at"] = std::move(at);
  if (!known.empty()) points["nominal"] = std::move(known);
  return points;
}

int start_and_watch(const OnlineOptions& online, const json::object& params) {
  RpcClient client = connect_for_campaign(online);
  const json::value started = value_or_throw(client.call("campaign.start", params));
  const json::object id{{"id", string_at(started, "/id")}};
  const int exit_code = follow(client, online, id);
  // A calibration has its report; what the others found is short.
  if (exit_code == kDone && !online.json && params.contains("kind"))
    print(online, value_or_throw(client.call("campaign.get", id)), campaign_text);
  return exit_code;
}

int resume_and_watch(const OnlineOptions& online, const json::object& params) {
  RpcClient client = connect_for_campaign(online);
  const json::value resumed = value_or_throw(client.call("campaign.resume", params));
  return follow(client, online, {{"id", string_at(resumed, "/id")}});
}

int watch_campaign(const OnlineOptions& online, const json::object& params) {
  RpcClient client = connect_for_campaign(online);
  return follow(client, online, params);
}

int list_campaigns(const OnlineOptions& online, const StoreFile& store) {
  print(online, campaign_source(online, store)->ask("campaign.list", {}), campaigns_text);
  return kDone;
}

int show_campaign(const OnlineOptions& online, const StoreFile& store, const json::object& params,
                  const CampaignFiles& files) {
  const auto source = campaign_source(online, store);
  const json::value found = source->ask("campaign.get", params);
  write_files(*source, found, files);
  print(online, found, campaign_text);
  return kDone;
}

int export_campaign(const OnlineOptions& online, const StoreFile& store, const json::object& params,
                    const CampaignFiles& files) {
  json::object written;
  for (const auto& [what, file] :
       {std::pair{"data", files.data}, std::pair{"joints", files.joints}, std::pair{"cycles", files.cycles},
        std::pair{"frame", files.frame}, std::pair{"document", files.document}})
    if (!file.empty()) written[what] = file.string();
  if (written.empty())
    throw bad_usage("campaign export: give --data, --document, --frame, --joints or --cycles");
  const auto source = campaign_source(online, store);
  const json::value found = source->ask("campaign.get", params);
  write_files(*source, found, files);
  print(online, {{"id", string_at(found, "/campaign/id")}, {"files", std::move(written)}},
        [](const json::value& answer) {
          std::string text = "campaign " + string_at(answer, "/id") + " written to";
          for (const auto& [what, file] : answer.at("files").as_object()) (text += ' ') += file.as_string();
          return text + "\n";
        });
  return kDone;
}

int check_drift(const OnlineOptions& online, const json::object& params) {
  RpcClient client = connect_for_campaign(online);
  const json::value started = value_or_throw(client.call("drift.check", params));
  const std::string id = string_at(started, "/id");
  json::value found = value_or_throw(client.call("campaign.get", {{"id", id}}));
  if (!found.at("progress").is_null()) {
    watch_to_end(client, id, found.at("progress"), online.json);
    found = value_or_throw(client.call("campaign.get", {{"id", id}}));
  }
  const json::value& document = found.at("drift");
  if (document.is_null())
    throw CommandError{kFailed, "the drift check " + string_at(found, "/campaign/state") + ": " +
                                    string_at(found, "/campaign/reason")};
  const auto drift = record::read_drift_document(document.as_object());
  if (!drift) throw CommandError{kFailed, "the daemon's drift document: " + drift.error()};
  print(online.json ? control::json_text(document) + "\n" : "\n" + drift_text(*drift));
  if (drift->update && drift->update->offered) return kDone;
  return drift->verdict == DriftVerdict::Failed ? kFailed : kDone;
}

}  // namespace truepose::tools
