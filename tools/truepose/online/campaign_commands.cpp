#include "tools/truepose/online/campaign_commands.hpp"

#include <boost/json/value.hpp>
#include <cstdio>
#include <sstream>
#include <utility>
#include <vector>

#include "config/frame_file.hpp"
#include "config/measurement_file.hpp"
#include "config/table/csv_reader.hpp"
#include "config/table/table_reading.hpp"
#include "config/target_file.hpp"
#include "config/text_file.hpp"
#include "proto/control/json_text.hpp"
#include "proto/record/frame_document.hpp"
#include "tools/truepose/online/campaign_watch.hpp"
#include "tools/truepose/online/online_text.hpp"
#include "tools/truepose/written_files.hpp"

namespace truepose::tools {
namespace {

namespace json = boost::json;

// ---- Files ----

/// The joints that were found for targets, CSV: q1..qN, and the last error in residual_mm. Targets without
/// joints are left out.
std::string joints_csv(const rpc::TargetsDocument& document) {
  std::string header, rows;
  for (const auto& target : document.targets) {
    if (target.joints_deg.empty() || target.errors_mm.empty()) continue;
    header.clear();
    for (const std::string& name : config::joint_column_names("q", target.joints_deg.size()))
      header += name + ",";
    for (const double joint : target.joints_deg) rows += control::json_text(joint) + ",";
    rows += control::json_text(target.errors_mm.back()) + "\n";
  }
  return header + "residual_mm\n" + rows;
}

/// The cycles of an ISO 9283 test, CSV as `truepose iso9283` reads it: points in the tracker's frame, where
/// they were commanded in the robot's base. The rows of several campaigns in one file show the drift.
///
/// @param started  of the campaign, which names the series
/// @param points   all points of the campaign
std::string cycles_csv(const rpc::Iso9283Document& iso9283, const std::string& started,
                       const std::vector<rpc::Point>& points) {
  const std::size_t stops = iso9283.commanded.size();
  std::string csv = "time,point,cycle,direction,x,y,z,cx,cy,cz\n";
  for (const rpc::Point& point : points) {
    if (!point.p_mm || stops == 0) continue;
    const auto pose = static_cast<std::size_t>(point.pose) - 1;
    const auto& asked = iso9283.commanded[pose % stops];
    csv += started + "," + asked.point + "," + std::to_string(pose / stops + 1) + "," + asked.direction;
    for (const Eigen::Vector3d& p_mm : {*point.p_mm, asked.p_mm})
      for (const double coordinate : p_mm) (csv += ',') += control::json_text(coordinate);
    csv += '\n';
  }
  return csv;
}

/// All points of a campaign, page by page.
std::vector<rpc::Point> all_points(CampaignSource& source, const std::string& id) {
  std::vector<rpc::Point> points;
  for (;;) {
    const rpc::CampaignGet request{
        .id = id, .points_offset = points.size(), .points_limit = 50};  // that surely fit into a line
    const std::vector<rpc::Point> more = source.ask(request).record.points;
    if (more.empty()) return points;
    points.insert(points.end(), more.begin(), more.end());
  }
}

/// The measurement file of a campaign, part by part.
std::string measurements_of(CampaignSource& source, const std::string& id) {
  std::string csv;
  for (;;) {
    const std::string more = source.ask(rpc::CampaignExport{.id = id, .offset = csv.size()}).data;
    if (more.empty()) return csv;
    csv += more;
  }
}

using FoundCampaign = rpc::CampaignGet::Result;

/// @param document  of the campaign
/// @param kind      what the campaign must be to have it: "targets", "iso9283"
const json::value& required(const json::value& document, const FoundCampaign& found,
                            const std::string& kind) {
  if (!document.is_null()) return document;
  throw CommandError{kFailed,
                     "campaign " + found.campaign.id + " is not of kind " + kind + ", or is not done"};
}

template <class Document>
Document read_stored(const json::value& stored) {
  auto document = record::from_json<Document>(stored);
  if (!document) throw CommandError{kFailed, "the daemon's document: " + document.error()};
  return *std::move(document);
}

/// Of a campaign of any kind.
json::value any_document(CampaignSource& source, const FoundCampaign& found) {
  const std::string& kind = found.campaign.kind;
  if (kind == "calibration") return whole_report(source, found.campaign.id);
  if (kind == "targets") return required(found.targets, found, kind);
  if (kind == "iso9283") return required(found.iso9283, found, kind);
  if (kind == "drift") return required(found.drift, found, kind);
  return required(found.frame, found, "frame");
}

/// The file of a tool or a base that was measured.
std::string frame_file(const FoundCampaign& found) {
  const std::string start = "campaign " + found.campaign.id;
  if (found.frame.is_null())
    throw CommandError{kFailed, start + " measured no tool and no base, or is not done"};
  std::string yaml = read_stored<record::FrameDocument>(found.frame).yaml;
  if (yaml.empty()) throw CommandError{kFailed, start + ": " + found.campaign.reason};
  return yaml;
}

/// What was written, by what it is.
struct ExportedCampaign {
  std::string id;
  record::ByName<std::filesystem::path> files;
};
void layout(record::Io& io, ExportedCampaign& x) {
  io("id", x.id);
  io("files", x.files);
}

/// All of them, or none.
void write_files(CampaignSource& source, const FoundCampaign& found, const CampaignFiles& files) {
  const std::string& id = found.campaign.id;
  std::vector<config::TextFile> made;
  if (!files.data.empty()) made.push_back({files.data, measurements_of(source, id)});
  if (!files.joints.empty()) {
    const json::value& targets = required(found.targets, found, "targets");
    made.push_back({files.joints, joints_csv(read_stored<rpc::TargetsDocument>(targets))});
  }
  if (!files.cycles.empty()) {
    const json::value& iso9283 = required(found.iso9283, found, "iso9283");
    made.push_back({files.cycles, cycles_csv(read_stored<rpc::Iso9283Document>(iso9283),
                                             found.campaign.started, all_points(source, id))});
  }
  if (!files.frame.empty()) made.push_back({files.frame, frame_file(found)});
  if (!files.document.empty())
    made.push_back({files.document, control::json_text(any_document(source, found)) + "\n"});
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
/// @param id  empty: the newest
int follow(RpcClient& client, const OnlineOptions& online, const std::string& id) {
  const auto present = value_or_throw(client.call(rpc::CampaignGet{.id = unless_empty(id)}));
  if (!present.record.progress) {  // over already
    print(online, present.json, campaign_text(present.record));
    return present.record.campaign.state == "done" ? kDone : kFailed;
  }
  const auto last = watch_to_end(client, *present.record.progress, online.json);
  print(online, last.json, online.json ? "" : ending_text(client, last.record));
  return last.record.phase == "done" ? kDone : kFailed;
}

}  // namespace

void add_targets(const std::filesystem::path& file, rpc::CampaignStart& request) {
  std::istringstream in{config::read_text_file(file, config::CsvTable::kMostBytes)};
  const config::TableReading reading{.report = print_to_stderr};
  config::TargetReader reader{in, file.string(), {.reading = &reading}};
  while (auto row = reader.next()) {
    if (reader.form() == config::TargetForm::Joints)
      request.joints.push_back(std::move(row->numbers));
    else
      request.poses.emplace_back(row->numbers.data());
  }
}

void add_points(const std::filesystem::path& file, rpc::CampaignStart& request) {
  const config::TableReading reading{.report = print_to_stderr};
  for (const config::PlannedPoint& point : config::load_points(file, &reading)) {
    request.points.push_back(point.name);
    if (point.at_mm) request.at.push_back(*point.at_mm);
    if (point.known_mm) request.nominal.push_back(*point.known_mm);
  }
}

int start_and_watch(const OnlineOptions& online, const rpc::CampaignStart& request) {
  RpcClient client = connect_for_campaign(online);
  const std::string id = value_or_throw(client.call(request)).record.id;
  const int exit_code = follow(client, online, id);
  // A calibration has its report; what the others found is short.
  if (exit_code == kDone && !online.json && request.kind != "calibration")
    print(campaign_text(value_or_throw(client.call(rpc::CampaignGet{.id = id})).record));
  return exit_code;
}

int resume_and_watch(const OnlineOptions& online, const std::string& id) {
  RpcClient client = connect_for_campaign(online);
  const auto resumed = value_or_throw(client.call(rpc::CampaignResume{.id = unless_empty(id)}));
  return follow(client, online, resumed.record.id);
}

int watch_campaign(const OnlineOptions& online, const std::string& id) {
  RpcClient client = connect_for_campaign(online);
  return follow(client, online, id);
}

int list_campaigns(const OnlineOptions& online, const StoreFile& store) {
  const auto list = campaign_source(online, store)->ask(rpc::CampaignList{});
  print(online, list.json, campaigns_text(list.record));
  return kDone;
}

int show_campaign(const OnlineOptions& online, const StoreFile& store, const std::string& id,
                  const CampaignFiles& files) {
  const auto source = campaign_source(online, store);
  const auto found = source->ask(rpc::CampaignGet{.id = unless_empty(id)});
  write_files(*source, found.record, files);
  print(online, found.json, campaign_text(found.record));
  if (!online.json) note_written({files.data, files.joints, files.cycles, files.frame, files.document});
  return kDone;
}

int export_campaign(const OnlineOptions& online, const StoreFile& store, const std::string& id,
                    const CampaignFiles& files) {
  ExportedCampaign exported;
  std::string names;
  for (const auto& [what, file] :
       {std::pair{"data", files.data}, std::pair{"joints", files.joints}, std::pair{"cycles", files.cycles},
        std::pair{"frame", files.frame}, std::pair{"document", files.document}}) {
    if (file.empty()) continue;
    exported.files.emplace_back(what, file);
    names += " " + file.string();
  }
  if (exported.files.empty())
    throw bad_usage("campaign export: give --data, --document, --frame, --joints or --cycles");
  const auto source = campaign_source(online, store);
  const FoundCampaign found = source->ask(rpc::CampaignGet{.id = unless_empty(id)}).record;
  write_files(*source, found, files);
  exported.id = found.campaign.id;
  print(online, record::to_json(exported), "campaign " + exported.id + " written to" + names + "\n");
  return kDone;
}

int check_drift(const OnlineOptions& online, const rpc::DriftCheck& request) {
  RpcClient client = connect_for_campaign(online);
  const rpc::CampaignGet started{.id = value_or_throw(client.call(request)).record.id};
  FoundCampaign found = value_or_throw(client.call(started)).record;
  if (found.progress) {
    watch_to_end(client, *found.progress, online.json);
    found = value_or_throw(client.call(started)).record;
  }
  if (found.drift.is_null())
    throw CommandError{kFailed, "the drift check " + found.campaign.state + ": " + found.campaign.reason};
  const auto drift = record::from_json<record::DriftDocument>(found.drift);
  if (!drift) throw CommandError{kFailed, "the daemon's drift document: " + drift.error()};
  print(online, found.drift, "\n" + drift_text(*drift));
  if (drift->update && drift->update->offered) return kDone;
  return drift->verdict == DriftVerdict::Failed ? kFailed : kDone;
}

}  // namespace truepose::tools
