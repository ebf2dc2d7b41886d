#include <vector>

#include "core/calibrate/option_names.hpp"
#include "tools/truepose/online/online_row.hpp"
#include "tools/truepose/online/online_text.hpp"
#include "tools/truepose/text.hpp"

namespace truepose::tools {
namespace {

std::string started_text(const rpc::CampaignStart::Result& started) {
  return "campaign " + started.id + " runs; follow it with: truepose campaign watch\n";
}

std::string progress_text(const rpc::CampaignProgress& progress) { return progress_line(progress) + "\n"; }

/// Of a verdict, what is shown here.
struct ShownVerdict {
  struct Finding {
    std::string sentence;
  };
  std::vector<Finding> findings;
};
void layout(record::Io& io, ShownVerdict::Finding& x) { io("sentence", x.sentence); }
void layout(record::Io& io, ShownVerdict& x) { io.defaulted("findings", x.findings); }

std::string identified_text(const rpc::CampaignIdentify::Result& made) {
  std::string text = "campaign " + made.id + ": model " + made.model_id;
  text += ", identified from " + shown(made.identify_poses) + " poses";
  text += made.validation_after_mm
              ? ", " + shown(made.validation_after_mm, 3, " mm") + " on " + shown(made.validate_poses) +
                    " validation poses (" + shown(made.validation_before_mm, 3, " mm") + " before)\n"
              : ", validated on none\n";
  const auto verdict = value_or_throw(received<ShownVerdict>(made.verdict, "campaign.identify: verdict"));
  for (const auto& finding : verdict.record.findings) text += finding.sentence + "\n";
  if (!made.reason.empty()) text += made.reason + "\n";
  text += "next: truepose report " + made.id + " --html report.html";
  return text + (made.activated ? "\n" : "; truepose model activate " + made.model_id + "\n");
}

/// Numbers as a list of positions.
std::vector<Eigen::Vector3d> positions_of(const std::vector<double>& numbers, const char* option) {
  if (numbers.size() % 3 != 0)
    throw bad_usage(std::string{"campaign start: "} + option + ": expected three numbers for each point");
  std::vector<Eigen::Vector3d> rows;
  for (std::size_t i = 0; i < numbers.size(); i += 3)
    rows.emplace_back(numbers[i], numbers[i + 1], numbers[i + 2]);
  return rows;
}

/// What is asked for of a tool or a base beyond what options are read into.
void add_frame(const OnlineArguments& given, rpc::CampaignStart& request) {
  request.kind = given.tool ? "tool" : "base";
  request.number = given.tool ? given.tool : given.base;
  request.at = positions_of(given.at, "--at");
  request.nominal = positions_of(given.nominal, "--nominal");
  request.facing = positions_of(given.facing, "--facing");
  request.orientation = positions_of(given.orientation, "--orientation");
  if (!given.points_file.empty()) add_points(given.points_file, request);
  if (request.touch && !request.at.empty())
    throw CommandError{kBadInput, given.points_file.string() +
                                      ": the columns x,y,z are for the tracker, and --touch does "
                                      "without: leave one of both out"};
}

int start_campaign(const OnlineArguments& given, const json::object&) {
  rpc::CampaignStart request = given.start;
  request.compensate = !given.uncompensated;
  request.activate = !given.no_activate;
  if (given.seed) request.seed = static_cast<std::uint64_t>(*given.seed);
  if (!given.targets.empty()) add_targets(given.targets, request);
  if (given.tool || given.base) add_frame(given, request);
  if (given.watch) return start_and_watch(given.online, request);
  return ask<rpc::CampaignStart>(given.online, record::to_json(request), started_text);
}

int resume_campaign(const OnlineArguments& given, const json::object& params) {
  if (given.watch) return resume_and_watch(given.online, given.id);
  return ask<rpc::CampaignResume>(given.online, params, progress_text);
}

// clang-format off
std::vector<Option> store_options(OnlineArguments& a) {
  return {
      {"--store", &a.store.store, "The file of a store, or a copy of it, instead of a daemon",
       {.excludes = {"--daemon"}, .file = FileUse::Read}},
      {"--robot", &a.store.robot, "Robot file, where no model of the store says which joints turn",
       {.needs = {"--store"}, .file = FileUse::Read}}};
}

std::vector<Option> file_options(OnlineArguments& a, const char* which) {
  return {
      id_option(a, "campaign", which),
      {"--data", &a.files.data,
       "Write its points here (CSV) as they were measured, as truepose calibrate --data reads them; of a "
       "tool or a base, as truepose tool and truepose base do", {.file = FileUse::Written}},
      {"--joints", &a.files.joints, "Write the joints that were found for targets here (CSV)",
       {.file = FileUse::Written}},
      {"--cycles", &a.files.cycles,
       "Write the cycles of an ISO 9283 test here (CSV), as truepose iso9283 --data reads them",
       {.file = FileUse::Written}},
      {"--frame", &a.files.frame,
       "Write the tool or base that was measured here (YAML), as --out of truepose tool and truepose base does",
       {.file = FileUse::Written}},
      {"--document", &a.files.document,
       "Write what it found here (JSON); of a calibration, as truepose report --document reads it, of an ISO "
       "9283 test, as --iso9283 does", {.file = FileUse::Written}}};
}
// clang-format on

std::vector<Option> with(std::vector<Option> options, const std::vector<Option>& more) {
  options.insert(options.end(), more.begin(), more.end());
  return options;
}

}  // namespace

// clang-format off
std::vector<OnlineRow> campaign_rows(OnlineArguments& a) {
  return {
      {"campaign", "", "Measure and identify the arm"},
      {"campaign start", "campaign.start", "Start a campaign",
       {{"--kind", &a.start.kind, "What to measure for",
         {.shows_default = true, .check = available({"calibration", "targets", "iso9283"})}},
        {"--targets", &a.targets,
         "Targets (CSV: q1..qN in deg, or x,y,z,a,b,c of the flange); default: validation poses of a plan",
         {.file = FileUse::Read}},
        {"--rounds", &a.start.rounds, "Corrections of a target at most"},
        {"--tolerance", &a.start.tolerance_mm, "Distance to which the mean of its readings must come", {.type = "MM"}},
        {"--readings", &a.start.readings, "Readings of the tracker in each round, or of each point of a base; touches default to one"},
        {"--cycles", &a.start.cycles, "Cycles of an ISO 9283 test; default as configured"},
        {"--variation", &a.start.variation,
         "ISO 9283: come to P1, P2 and P4 along the three axes of the base too, for vAP; default as "
         "configured"},
        {"--uncompensated", &a.uncompensated, "ISO 9283 of the nominal arm; needs no model"},
        {"--identify", &a.start.identify_poses, "Poses to identify from"},
        {"--validate", &a.start.validate_poses, "Poses to validate on"},
        {"--seed", &a.seed, "Seed of the planner"},
        {"--remeasure", &a.start.remeasure,
         "Measure the validation poses again with compensated joints; default as configured"},
        {"--no-activate", &a.no_activate, "Keep the model inactive"},
        {"--tool", &a.tool, "Measure the tool of this number in TOOL_DATA, with the active model",
         {.check = in_range(1, 1000), .excludes = {"--kind"}}},
        {"--base", &a.base,
         "Measure the work frame of this number in BASE_DATA: a reflector is put to its points by hand, the arm stands still",
         {.check = in_range(1, 1000), .excludes = {"--kind", "--tool"}}},
        {"--touch", &a.start.touch,
         "The points of the base are touched by the TCP of the tool of this number, which has to be in use: the arm is jogged there",
         {.check = in_range(1, 1000), .needs = {"--base"}, .excludes = {"--at"}}},
        {"--points", &a.start.points,
         "Points of the frame, where a reflector sits: origin, x (on +X) and xy (in the XY plane, +Y side), or any names with --nominal; of "
         "a tool origin, the TCP, alone too, and by default. From one to the next it is put by hand: the campaign pauses for that"},
        {"--at", &a.at,
         "Where each point is, roughly (x,y,z in mm, point after point): of a tool in the flange frame, of a base in the "
         "robot's; default: where the TCP is known to be, else where the cell file has its reflector", {.type = "X,Y,Z,.."}},
        {"--nominal", &a.nominal, "Coordinates of each point in the frame, where they are known (x,y,z in mm)", {.type = "X,Y,Z,.."}},
        {"--points-file", &a.points_file,
         "The points from a file (CSV: point; x,y,z as --at, but of points to touch; px,py,pz as --nominal)",
         {.excludes = {"--points", "--at", "--nominal"}, .file = FileUse::Read}},
        {"--facing", &a.facing, "Direction of the reflector's opening in the flange frame; default: the cell file's",
         {.type = "X,Y,Z", .count = 3, .needs = {"--tool"}}},
        {"--orientation", &a.orientation,
         "Orientation of the tool as a,b,c (deg), where the TCP alone is measured; otherwise the flange's",
         {.type = "A,B,C", .count = 3, .needs = {"--tool"}}},
        {"--together", &a.start.together, "Reflectors sit at all points of the tool at once",
         {.needs = {"--tool"}}},
        {"--tool-poses", &a.start.poses_per_point, "Poses in which each point is measured; below 4 for a 6-D target alone; default: 10",
         {.check = in_range(1, 100), .needs = {"--tool"}}},
        {"--note", &a.start.note, "What for: shown with the campaign and in its report", {.type = "TEXT"}},
        {"--watch", &a.watch, "Follow it to its end"}},
       start_campaign,
       {{"campaign start --watch", "Calibrate as the cell file says, and follow it"},
        {"campaign start --identify 50 --validate 10 --watch"},
        {"campaign start --tool 3 --watch", "Measure the tool of TOOL_DATA[3]"},
        {"campaign start --kind iso9283 --cycles 30 --watch"}}},
      asks<rpc::CampaignPause>("campaign pause", "Pause the campaign that runs", {}, progress_text),
      {"campaign resume", "campaign.resume", "Resume the campaign that is paused, or was interrupted",
       {id_option(a, "campaign", "Campaign that was interrupted; default: the one that is paused"),
        {"--watch", &a.watch, "Follow it to its end"}},
       resume_campaign},
      asks<rpc::CampaignAbort>("campaign abort", "Abort the campaign that runs, or was interrupted",
       {id_option(a, "campaign", "Campaign that was interrupted; default: the one that runs")}, progress_text),
      asks<rpc::CampaignIdentify>("campaign identify",
       "Identify the stored points of a campaign again, also of an aborted or failed one",
       {id_option(a, "campaign", "Campaign", true),
        {"--non-geometric", &a.non_geometric, "Non-geometric errors of the joints; this and what follows: default as configured",
         {.check = available(names_of(kNoneOrAuto)), .key = "non_geometric"}},
        {"--harmonics", &a.harmonics, "Multiples of a joint's angle to look for", {.key = "harmonics"}},
        {"--residual", &a.residual, "Gaussian process over what the model leaves: none, auto or gp", {.key = "residual"}},
        {"--loss", &a.loss, "How points that are far off weigh", {.key = "loss"}},
        {"--prior", &a.prior, "Whether deviations from the data sheet are taken as small until measured: auto, off or on",
         {.key = "prior"}},
        {"--correct-by-nests", &a.correct_by_nests, "Put the points right by how the tracker's nests moved",
         {.key = "correct_by_nests"}},
        {"--split", &a.split,
         "Share of the poses that identify, the others validate; default: as measured, and 0.7 where none validates",
         {.type = "SHARE", .key = "split"}},
        {"--seed", &a.seed, "Seed of the split", {.key = "seed"}},
        {"--activate", &a.activate, "Take the model into use, if nothing contradicts it", {.key = "activate"}}},
       identified_text,
       {{"campaign identify latest --non-geometric auto"}}),
      {"campaign list", "campaign.list", "Campaigns, newest first", store_options(a),
       [](const OnlineArguments& x, const json::object&) { return list_campaigns(x.online, x.store); }},
      {"campaign show", "campaign.get", "One campaign",
       with(file_options(a, "Campaign; default: the newest"), store_options(a)),
       [](const OnlineArguments& x, const json::object&) {
         return show_campaign(x.online, x.store, x.id, x.files);
       },
       {{"campaign show latest"}}},
      {"campaign export", "campaign.get", "What a campaign measured and found, as files",
       with(file_options(a, "Campaign; default: the newest"), store_options(a)),
       [](const OnlineArguments& x, const json::object&) {
         return export_campaign(x.online, x.store, x.id, x.files);
       },
       {{"campaign export latest --data points.csv"}}},
      {"campaign watch", "campaign.get", "Follow a campaign to its end", {id_option(a, "campaign", "Campaign; default: the newest")},
       [](const OnlineArguments& x, const json::object&) { return watch_campaign(x.online, x.id); }},
  };
}
// clang-format on

}  // namespace truepose::tools
