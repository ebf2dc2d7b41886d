#include "tools/truepose/online/online_commands.hpp"

#include <boost/json/array.hpp>
#include <boost/json/object.hpp>
#include <boost/json/value_from.hpp>
#include <cstdio>
#include <memory>
#include <tuple>
#include <type_traits>

#include "config/text_file.hpp"
#include "proto/control/json_text.hpp"
#include "tools/truepose/online/backup_command.hpp"
#include "tools/truepose/online/campaign_commands.hpp"
#include "tools/truepose/online/campaign_source.hpp"
#include "tools/truepose/online/online_text.hpp"
#include "tools/truepose/online/recording_commands.hpp"
#include "tools/truepose/online/rpc_client.hpp"
#include "tools/truepose/text.hpp"

namespace truepose::tools {
namespace {

namespace json = boost::json;

/// Everything that options are read into.
struct Arguments {
  OnlineOptions online;
  std::string id;
  std::filesystem::path out;
  // campaign start
  std::string kind = "calibration";
  std::filesystem::path targets;
  std::optional<int> rounds, readings, cycles, identify_poses, validate_poses;
  std::optional<double> tolerance_mm;
  std::optional<bool> variation, remeasure;
  std::optional<std::int64_t> seed;
  bool uncompensated = false, no_activate = false, watch = false;
  std::optional<int> tool, base, touch, tool_poses;
  std::vector<std::string> points;
  std::filesystem::path points_file;
  std::vector<double> at, known, facing, orientation;
  bool together = false;
  std::string note;
  // campaign identify
  std::string deviation, residual, loss, prior;
  std::vector<int> harmonics;
  std::optional<bool> correct_by_nests;
  std::optional<double> split;
  bool activate = false;
  // the others
  CampaignFiles files;
  StoreFile store;
  std::vector<std::string> topics;
  std::optional<std::int64_t> after;
  std::optional<std::uint64_t> count;
  std::string method, params;
  std::optional<int> lease_s, limit;
  ReportOptions report;
};

/// A command that the daemon answers: it calls the method with those of its options that are parameters of
/// it, and prints the answer.
struct Row {
  std::string name, method, help;
  std::vector<Option> options{};
  std::string (*text)(const json::value& answer) = nullptr;
  int (*run)(const Arguments& given, const json::object& params) = nullptr;  ///< where that is not all
};

// ---- Texts of one sentence ----

std::string started_text(const json::value& started) {
  return "campaign " + string_at(started, "/id") + " runs; follow it with: truepose campaign watch\n";
}

std::string progress_text(const json::value& progress) { return progress_line(progress) + "\n"; }

std::string activated_text(const json::value& model) {
  return "model " + string_at(model, "/id") + " is active\n";
}

std::string deactivated_text(const json::value& result) {
  const std::string id = string_at(result, "/deactivated");
  return id.empty() ? "no model was active\n" : "model " + id + " is no longer active\n";
}

std::string tool_in_use_text(const json::value& tool) {
  return "tool " + text_at(tool, "/number") + " is in use as campaign " + string_at(tool, "/campaign_id") +
         " measured it; the controller has to have " + string_at(tool, "/krl") + "\n";
}

std::string tool_out_of_use_text(const json::value& result) {
  return "the tool that campaign " + string_at(result, "/deactivated") + " measured is no longer in use\n";
}

std::string exported_text(const json::value& model) { return string_at(model, "/yaml"); }

std::string identified_text(const json::value& made) {
  std::string text = "campaign " + string_at(made, "/id") + ": model " + string_at(made, "/model_id");
  text += ", identified from " + text_at(made, "/identify_poses") + " poses";
  text += find_at(made, "/validation_after_mm")
              ? ", " + number_at(made, "/validation_after_mm", 3, " mm") + " on " +
                    text_at(made, "/validate_poses") + " validation poses (" +
                    number_at(made, "/validation_before_mm", 3, " mm") + " before)\n"
              : ", validated on none\n";
  for (const json::value& finding : list_at(made, "/verdict/findings"))
    text += text_at(finding, "/sentence") + "\n";
  if (const std::string reason = string_at(made, "/reason"); !reason.empty()) text += reason + "\n";
  text += "next: truepose report " + string_at(made, "/id") + " --html report.html";
  return text + (is_true_at(made, "/activated")
                     ? "\n"
                     : "; truepose model activate " + string_at(made, "/model_id") + "\n");
}

std::string answer_text(const json::value& answer) { return control::json_text(answer) + "\n"; }

// ---- Commands that are more than a call and its text ----

int ask(const OnlineOptions& online, const std::string& method, const json::object& params,
        std::string (*text)(const json::value&)) {
  RpcClient client = value_or_throw(RpcClient::connect(online));
  print(online, value_or_throw(client.call(method, params)), text);
  return kDone;
}

/// Numbers as a list of positions; none where there are none.
std::optional<json::array> positions_of(const std::vector<double>& numbers, const char* option) {
  if (numbers.empty()) return std::nullopt;
  if (numbers.size() % 3 != 0)
    throw bad_usage(std::string{"campaign start: "} + option + ": expected three numbers for each point");
  json::array rows;
  for (std::size_t i = 0; i < numbers.size(); i += 3)
    rows.push_back(json::array{numbers[i], numbers[i + 1], numbers[i + 2]});
  return rows;
}

/// What is asked for of a tool or a base beyond what are parameters as they stand.
void add_frame(const Arguments& given, json::object& params) {
  params["kind"] = given.tool ? "tool" : "base";
  params["number"] = given.tool ? *given.tool : *given.base;
  if (given.tool_poses) params["poses_per_point"] = *given.tool_poses;
  if (!given.points_file.empty())
    for (const auto& [key, value] : points_of_file(given.points_file)) params[key] = value;
  for (const auto& [key, option, numbers] : {std::tuple{"at", "--at", &given.at},
                                             {"known", "--known", &given.known},
                                             {"facing", "--facing", &given.facing},
                                             {"orientation", "--orientation", &given.orientation}})
    if (auto rows = positions_of(*numbers, option)) params[key] = *std::move(rows);
  if (given.touch && params.contains("at"))
    throw CommandError{kBadInput, given.points_file.string() +
                                      ": the columns x,y,z are for the tracker, and --touch does "
                                      "without: leave one of both out"};
}

int start_campaign(const Arguments& given, const json::object& params) {
  json::object all = given.targets.empty() ? json::object{} : targets_of_file(given.targets);
  for (const auto& [key, value] : params) {
    if (key != "kind" || given.kind != "calibration") all[key] = value;
  }
  if (given.tool || given.base) add_frame(given, all);
  if (given.watch) return start_and_watch(given.online, all);
  return ask(given.online, "campaign.start", all, started_text);
}

int resume_campaign(const Arguments& given, const json::object& params) {
  if (given.watch) return resume_and_watch(given.online, params);
  return ask(given.online, "campaign.resume", params, progress_text);
}

int export_model(const Arguments& given, const json::object& params) {
  if (given.out.empty()) return ask(given.online, "model.export", params, exported_text);
  RpcClient client = value_or_throw(RpcClient::connect(given.online));
  const json::value model = value_or_throw(client.call("model.export", params));
  config::write_text_file(given.out, string_at(model, "/yaml"));
  print(given.online, {{"id", string_at(model, "/id")}, {"file", given.out.string()}},
        [](const json::value& written) {
          return "model " + string_at(written, "/id") + " written to " + string_at(written, "/file") + "\n";
        });
  return kDone;
}

int print_events(const Arguments& given, const json::object& params) {
  RpcClient client = value_or_throw(RpcClient::connect(given.online));
  const json::value subscribed = value_or_throw(client.call("events.subscribe", params));
  for (const json::value& gap : list_at(subscribed, "/missing"))
    std::fprintf(stderr, "truepose: events %s to %s may be missing: %s\n", text_at(gap, "/first").c_str(),
                 text_at(gap, "/last").c_str(), text_at(gap, "/reason").c_str());
  for (std::uint64_t seen = 0; !given.count || seen < *given.count; ++seen) {
    const control::Event event = value_or_throw(client.next_event());
    print(given.online.json
              ? answer_text(
                    {{"seq", event.seq}, {"time", event.time}, {"topic", event.topic}, {"data", event.data}})
              : event_line(event) + "\n");
  }
  return kDone;
}

int call_method(const Arguments& given, const json::object&) {
  if (given.params.empty()) return ask(given.online, given.method, {}, answer_text);
  const auto parsed = control::parse_json(given.params);
  if (!parsed) throw CommandError{kBadInput, "call: JSON: " + parsed.error()};
  if (!parsed->is_object())
    throw CommandError{kBadInput, "call: JSON: expected an object, such as {\"limit\": 5}"};
  return ask(given.online, given.method, parsed->get_object(), answer_text);
}

// ---- The table ----

std::vector<Option> connection_options(OnlineOptions& online) {
  return {
      {"--daemon", &online.daemon,
       "HOST:PORT of the daemon, or the path of its control socket; default: the control socket of the one "
       "that runs here, else 127.0.0.1:7210"},
      {"--token-file",
       &online.token_file,
       "file with the daemon's token, for HOST:PORT",
       {.environment = "TRUEPOSE_TOKEN_FILE", .file = FileUse::Read}},
      {"--tls-ca",
       &online.tls.ca,
       "HOST:PORT is the daemon's TLS port, whose certificate has to be from this CA (PEM)",
       {.environment = "TRUEPOSE_TLS_CA", .file = FileUse::Read}},
      {"--cert",
       &online.tls.certificate,
       "certificate to be known by (PEM) instead of a token",
       {.needs = {"--tls-ca", "--key"}, .file = FileUse::Read}},
      {"--key",
       &online.tls.key,
       "private key of --cert (PEM)",
       {.needs = {"--cert"}, .file = FileUse::Read}}};
}

// clang-format off
std::vector<Row> table(Arguments& a) {
  const auto id = [&a](const char* help, bool required = false) {
    return Option{"ID", &a.id, help, {.required = required, .key = "id"}};
  };
  const auto store_options = [&a] {
    return std::vector<Option>{
        {"--store", &a.store.store, "the file of a store, or a copy of it, instead of a daemon",
         {.excludes = {"--daemon"}, .file = FileUse::Read}},
        {"--robot", &a.store.robot, "robot file, where no model of the store says which joints turn",
         {.needs = {"--store"}, .file = FileUse::Read}}};
  };
  const auto campaign_files = [&a, id](const char* which) {
    return std::vector<Option>{
        id(which),
        {"--data", &a.files.data,
         "write its points here (CSV) as they were measured, as truepose calibrate --data reads them; of a "
         "tool or a base, as truepose tool and truepose base do", {.file = FileUse::Written}},
        {"--joints", &a.files.joints, "write the joints that were found for targets here (CSV)",
         {.file = FileUse::Written}},
        {"--cycles", &a.files.cycles,
         "write the cycles of an ISO 9283 test here (CSV), as truepose iso9283 --data reads them",
         {.file = FileUse::Written}},
        {"--frame", &a.files.frame,
         "write the tool or base that was measured here (YAML), as --out of truepose tool and truepose base does",
         {.file = FileUse::Written}},
        {"--document", &a.files.document,
         "write what it found here (JSON); of a calibration, as truepose report --document reads it, of an ISO "
         "9283 test, as --iso9283 does", {.file = FileUse::Written}}};
  };
  const auto with = [](std::vector<Option> options, const std::vector<Option>& more) {
    options.insert(options.end(), more.begin(), more.end());
    return options;
  };
  return {
      {"status", "cell.status", "what the cell does, its devices, model, stream and faults", {}, status_text},
      {"connect", "cell.connect", "connect robot and tracker", {}, status_text},
      {"disconnect", "cell.disconnect", "let robot and tracker go", {}, status_text},
      {"acknowledge", "cell.acknowledge", "clear a fault whose cause is gone, or let a stream that holds go on",
       {}, status_text},

      {"campaign", "", "measure and identify the arm"},
      {"campaign start", "campaign.start", "start a campaign",
       {{"--kind", &a.kind, "what to measure for",
         {.shows_default = true, .check = member_of({"calibration", "targets", "iso9283"}), .key = "kind"}},
        {"--targets", &a.targets,
         "targets (CSV: q1..qN in deg, or x,y,z,a,b,c of the flange); default: validation poses of a plan",
         {.file = FileUse::Read}},
        {"--rounds", &a.rounds, "corrections of a target at most", {.key = "rounds"}},
        {"--tolerance", &a.tolerance_mm, "mm to which the mean of its readings must come",
         {.key = "tolerance_mm"}},
        {"--readings", &a.readings, "of the tracker in each round, or of each point of a base, of which one that is touched is so once by default", {.key = "readings"}},
        {"--cycles", &a.cycles, "of an ISO 9283 test; default as configured", {.key = "cycles"}},
        {"--variation", &a.variation,
         "ISO 9283: come to P1, P2 and P4 along the three axes of the base too, for vAP; default as "
         "configured",
         {.key = "variation"}},
        {"--uncompensated", &a.uncompensated, "ISO 9283 of the nominal arm; needs no model",
         {.key = "compensate", .flag_sends = false}},
        {"--identify", &a.identify_poses, "poses to identify from", {.key = "identify_poses"}},
        {"--validate", &a.validate_poses, "poses to validate on", {.key = "validate_poses"}},
        {"--seed", &a.seed, "seed of the planner", {.key = "seed"}},
        {"--remeasure", &a.remeasure,
         "measure the validation poses again with compensated joints; default as configured",
         {.key = "remeasure"}},
        {"--no-activate", &a.no_activate, "keep the model inactive", {.key = "activate", .flag_sends = false}},
        {"--tool", &a.tool, "measure the tool of this number in TOOL_DATA, with the active model",
         {.check = in_range(1, 1000), .excludes = {"--kind"}}},
        {"--base", &a.base,
         "measure the work frame of this number in BASE_DATA: a reflector is put to its points by hand, the arm stands still",
         {.check = in_range(1, 1000), .excludes = {"--kind", "--tool"}}},
        {"--touch", &a.touch,
         "the points of the base are touched by the TCP of the tool of this number, which has to be in use: the arm is jogged there",
         {.check = in_range(1, 1000), .needs = {"--base"}, .excludes = {"--at"}, .key = "touch"}},
        {"--points", &a.points,
         "of the frame, where a reflector sits: origin, x (on +X) and xy (in the XY plane, +Y side), or any names with --known; of "
         "a tool origin, the TCP, alone too, and by default. From one to the next it is put by hand: the campaign pauses for that",
         {.key = "points"}},
        {"--at", &a.at,
         "where each point is, roughly (x,y,z in mm, point after point): of a tool in the flange frame, of a base in the "
         "robot's; default: where the TCP is known to be, else where the cell file has its reflector"},
        {"--known", &a.known, "coordinates of each point in the frame, where they are known (x,y,z in mm)"},
        {"--points-file", &a.points_file,
         "the points from a file (CSV: point; x,y,z as --at, but of points to touch; px,py,pz as --known)",
         {.excludes = {"--points", "--at", "--known"}, .file = FileUse::Read}},
        {"--facing", &a.facing, "direction of the reflector's opening in the flange frame; default: the cell file's",
         {.count = 3, .needs = {"--tool"}}},
        {"--orientation", &a.orientation,
         "of the tool as a,b,c (deg), where the TCP alone is measured; otherwise the flange's",
         {.count = 3, .needs = {"--tool"}}},
        {"--together", &a.together, "reflectors sit at all points of the tool at once",
         {.needs = {"--tool"}, .key = "together"}},
        {"--tool-poses", &a.tool_poses, "in which each point is measured; default: 10",
         {.check = in_range(4, 100), .needs = {"--tool"}}},
        {"--note", &a.note, "what for: shown with the campaign and in its report", {.key = "note"}},
        {"--watch", &a.watch, "follow it to its end"}},
       nullptr, start_campaign},
      {"campaign pause", "campaign.pause", "pause the campaign that runs", {}, progress_text},
      {"campaign resume", "campaign.resume", "go on with the campaign that is paused, or was interrupted",
       {id("campaign that was interrupted; default: the one that is paused"),
        {"--watch", &a.watch, "follow it to its end"}},
       nullptr, resume_campaign},
      {"campaign abort", "campaign.abort", "abort the campaign that runs, or was interrupted",
       {id("campaign that was interrupted; default: the one that runs")}, progress_text},
      {"campaign identify", "campaign.identify",
       "identify the stored points of a campaign anew, of one that was aborted or has failed too",
       {id("campaign", true),
        {"--deviation", &a.deviation, "none, auto; this and what follows: default as configured",
         {.check = member_of({"none", "auto"}), .key = "deviation"}},
        {"--harmonics", &a.harmonics, "multiples of a joint's angle to look for", {.key = "harmonics"}},
        {"--residual", &a.residual, "residual field: none, auto, or its name", {.key = "residual"}},
        {"--loss", &a.loss, "how points that are far off weigh", {.key = "loss"}},
        {"--prior", &a.prior, "auto, off, on: deviations from the data sheet are taken as small until measured",
         {.key = "prior"}},
        {"--correct-by-nests", &a.correct_by_nests, "put the points right by how the tracker's nests moved",
         {.key = "correct_by_nests"}},
        {"--split", &a.split,
         "share of the poses that identify, the others validate; default: as measured, and 0.7 where none validates",
         {.key = "split"}},
        {"--seed", &a.seed, "seed of the split", {.key = "seed"}},
        {"--activate", &a.activate, "take the model into use, if nothing contradicts it", {.key = "activate"}}},
       identified_text},
      {"campaign list", "campaign.list", "campaigns, newest first", store_options(), nullptr,
       [](const Arguments& x, const json::object&) { return list_campaigns(x.online, x.store); }},
      {"campaign show", "campaign.get", "one campaign",
       with(campaign_files("campaign; default: the newest"), store_options()), nullptr,
       [](const Arguments& x, const json::object& params) {
         return show_campaign(x.online, x.store, params, x.files);
       }},
      {"campaign export", "campaign.get", "what a campaign measured and found, as files",
       with(campaign_files("campaign; default: the newest"), store_options()), nullptr,
       [](const Arguments& x, const json::object& params) {
         return export_campaign(x.online, x.store, params, x.files);
       }},
      {"campaign watch", "campaign.get", "follow a campaign to its end", {id("campaign; default: the newest")},
       nullptr,
       [](const Arguments& x, const json::object& params) { return watch_campaign(x.online, params); }},

      {"model", "", "the models that campaigns made"},
      {"model list", "model.list", "models, newest first", {}, models_text},
      {"model show", "model.get", "one model with its parameters",
       {id("model; default: the active one")}, model_text},
      {"model activate", "model.activate", "let a model correct the arm", {id("model", true)}, activated_text},
      {"model rollback", "model.rollback", "activate the model that was active before", {}, activated_text},
      {"model deactivate", "model.deactivate", "let no model correct the arm", {}, deactivated_text},
      {"model export", "model.export", "write a model file",
       {id("model; default: the active one"), {"--out", &a.out, "file; default: standard output",
       {.file = FileUse::Written}}},
       nullptr, export_model},

      {"tools", "", "the measured tools that are in use"},
      {"tools list", "tool.list", "the tools that are known by their numbers", {}, tools_text},
      {"tools activate", "tool.activate", "take the tool that a campaign measured into use, under its number",
       {id("campaign", true)}, tool_in_use_text},
      {"tools deactivate", "tool.deactivate", "take it out of use again; one of the cell file stays",
       {{"NUMBER", &a.tool, "in TOOL_DATA", {.required = true, .key = "number"}}}, tool_out_of_use_text},

      {"stream", "", "correct the arm while it works"},
      {"stream start", "stream.start", "ramp the corrections in", {}, stream_text},
      {"stream stop", "stream.stop", "ramp them out", {}, stream_text},
      {"stream arm", "stream.arm", "correct every program that opens RSI, from now on", {}, stream_text},
      {"stream disarm", "stream.disarm", "ramp out what is corrected, and correct no other", {}, stream_text},
      {"stream status", "stream.status", "counters of the stream", {}, stream_text},

      {"control", "", "who is in command"},
      {"control show", "control.get", "who has control", {}, control_text},
      {"control acquire", "control.acquire", "take control, or renew it",
       {{"--lease", &a.lease_s, "seconds until it ends unless it is renewed", {.key = "lease_s"}}}, control_text},
      {"control takeover", "control.takeover", "take control from a lower role too",
       {{"--lease", &a.lease_s, "seconds until it ends unless it is renewed", {.key = "lease_s"}}}, control_text},
      {"control release", "control.release", "give control back", {}, control_text},

      {"audit", "", "what was commanded, and by whom"},
      {"audit list", "audit.list", "commands, newest first",
       {{"--limit", &a.limit, "so many records at most", {.key = "limit"}}}, audit_text},

      {"recording", "", "what went over the wires to robot and tracker"},
      {"recording save", "recording.save", "write the last minutes to a file",
       {{"--out", &a.out, "file here; default: among the daemon's recordings alone",
       {.file = FileUse::Written}}}, nullptr,
       [](const Arguments& x, const json::object&) { return save_recording(x.online, x.out); }},
      {"recording list", "recording.list", "recordings, newest first", {}, recordings_text},
      {"recording export", "recording.get", "copy a recording to a file",
       {{"NAME", &a.id, "recording", {.required = true, .key = "name"}},
        {"--out", &a.out, "file", {.required = true, .file = FileUse::Written}}},
       nullptr, [](const Arguments& x, const json::object&) { return export_recording(x.online, x.id, x.out); }},

      {"backup", "store.backup", "copy the store while the daemon uses it",
       {{"--out", &a.out, "file here", {.required = true, .file = FileUse::Written}}}, nullptr,
       [](const Arguments& x, const json::object&) { return back_up(x.online, x.out); }},

      {"events", "events.subscribe", "print what happens",
       {{"--topics", &a.topics, "cell, campaign, measurement, stream, model, fault, log, control", {.key = "topics"}},
        {"--after", &a.after, "number of the last event seen: what followed comes first", {.key = "after"}},
        {"--count", &a.count, "end after so many"}},
       nullptr, print_events},
      {"call", "", "call any method of the daemon",
       {{"METHOD", &a.method, "such as cell.status", {.required = true}},
        {"JSON", &a.params, "its parameters, an object"}},
       nullptr, call_method},
      {"report", "report.get", "errors before and after: a table, and a page to keep",
       {{"ID", &a.report.campaign, "campaign; default: the newest that is done", {.key = "id"}},
        {"--document", &a.report.document, "a calibration document (JSON) instead of the daemon's",
         {.excludes = {"ID", "--store"}, .file = FileUse::Read}},
        {"--store", &a.report.store, "the file of a store, or a copy of it, instead of a daemon",
         {.excludes = {"--daemon"}, .file = FileUse::Read}},
        {"--truth", &a.report.truth, "what a simulated arm really is (truepose-sim --truth-file)",
         {.file = FileUse::Read}},
        {"--path", &a.report.path,
         "what a production program did (truepose-sim --path-file), to be a section of the page",
         {.file = FileUse::Read}},
        {"--iso9283", &a.report.iso9283,
         "an ISO 9283 test (truepose iso9283 --json), to be a section of the page", {.file = FileUse::Read}},
        {"--frame", &a.report.frame,
         "a tool that was measured (truepose tool --json, or campaign export --document), to be a section of the page",
         {.file = FileUse::Read}},
        {"--experiment", &a.report.experiment,
         "an experiment (truepose experiment --json), to be sections of the page", {.file = FileUse::Read}},
        {"--html", &a.report.html, "write the page here", {.file = FileUse::Written}},
        {"--out-json", &a.report.json, "write the document here", {.file = FileUse::Written}}},
       nullptr, [](const Arguments& x, const json::object&) { return report_campaign(x.online, x.report); }},
  };
}
// clang-format on

// ---- From rows to commands ----

/// The value of an option as a parameter; nothing where the option is not given.
std::optional<json::value> parameter_of(const Option& option) {
  return std::visit(
      [&]<class T>(T* value) -> std::optional<json::value> {
        if constexpr (std::same_as<T, bool>) {
          return *value ? std::optional<json::value>{option.rules.flag_sends} : std::nullopt;
        } else if constexpr (std::same_as<T, std::string>) {
          return value->empty() ? std::nullopt : std::optional<json::value>{*value};
        } else if constexpr (std::same_as<T, std::filesystem::path>) {
          return value->empty() ? std::nullopt : std::optional<json::value>{value->string()};
        } else if constexpr (requires { value->has_value(); }) {
          return *value ? std::optional<json::value>{**value} : std::nullopt;
        } else if constexpr (requires { value->begin(); }) {
          return value->empty() ? std::nullopt : std::optional<json::value>{json::value_from(*value)};
        } else {
          return *value;
        }
      },
      option.target);
}

json::object parameters_of(const std::vector<Option>& options) {
  json::object params;
  for (const Option& option : options) {
    if (option.rules.key.empty()) continue;
    if (auto value = parameter_of(option)) params[option.rules.key] = *std::move(value);
  }
  return params;
}

Command command_of(const Row& row, const std::shared_ptr<Arguments>& arguments) {
  Command command{.name = row.name, .help = row.help, .method = row.method};
  if (!row.text && !row.run) return command;  // a group
  command.options = connection_options(arguments->online);
  command.options.push_back({"--json", &arguments->online.json, "print one JSON document"});
  command.options.insert(command.options.end(), row.options.begin(), row.options.end());
  command.run = [row, arguments] {
    const json::object params = parameters_of(row.options);
    return row.run ? row.run(*arguments, params) : ask(arguments->online, row.method, params, row.text);
  };
  return command;
}

}  // namespace

void print(const std::string& text) {
  std::fputs(text.c_str(), stdout);
  std::fflush(stdout);
}

void print(const OnlineOptions& online, const json::value& answer, std::string (*text)(const json::value&)) {
  print(online.json ? control::json_text(answer) + "\n" : text(answer));
}

CommandLine online_commands() {
  const auto arguments = std::make_shared<Arguments>();
  CommandLine line{.options = connection_options(arguments->online), .commands = {}};
  for (const Row& row : table(*arguments)) line.commands.push_back(command_of(row, arguments));
  return line;
}

}  // namespace truepose::tools
