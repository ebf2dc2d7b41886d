#include "tools/truepose/online/online_commands.hpp"

#include <boost/json/object.hpp>
#include <boost/json/value_from.hpp>
#include <cstdio>
#include <memory>
#include <type_traits>

#include "config/text_file.hpp"
#include "proto/control/json_text.hpp"
#include "proto/rpc/events.hpp"
#include "tools/truepose/online/backup_command.hpp"
#include "tools/truepose/online/online_row.hpp"
#include "tools/truepose/online/online_text.hpp"
#include "tools/truepose/online/path_report.hpp"
#include "tools/truepose/online/recording_commands.hpp"
#include "tools/truepose/text.hpp"

namespace truepose::tools {
namespace {

// ---- Texts of one sentence ----

std::string activated_text(const rpc::ModelSummary& model) { return "model " + model.id + " is active\n"; }

std::string deactivated_text(const rpc::ModelDeactivate::Result& result) {
  return result.deactivated ? "model " + *result.deactivated + " is deactivated\n" : "no model was active\n";
}

std::string tool_in_use_text(const rpc::ToolInUse& tool) {
  return "tool " + shown(tool.number) + " is in use as campaign " + tool.campaign_id.value_or("") +
         " measured it; the controller has to have " + tool.krl.value_or("") + "\n";
}

std::string tool_out_of_use_text(const rpc::ToolDeactivate::Result& result) {
  return "the tool that campaign " + result.deactivated + " measured is not in use any more\n";
}

std::string exported_text(const rpc::ModelExport::Result& model) { return model.yaml; }

std::string json_line(const json::value& value) { return control::json_text(value) + "\n"; }

// ---- Commands that are more than a call and its text ----

struct ExportedModel {
  std::string id;
  std::filesystem::path file;
};
void layout(record::Io& io, ExportedModel& x) {
  io("id", x.id);
  io("file", x.file);
}

int export_model(const OnlineArguments& given, const json::object& params) {
  if (given.out.empty()) return ask<rpc::ModelExport>(given.online, params, exported_text);
  RpcClient client = value_or_throw(RpcClient::connect(given.online));
  const rpc::ModelExport request{.id = unless_empty(given.id)};
  const auto [id, yaml] = value_or_throw(client.call(request)).record;
  config::write_text_file(given.out, yaml);
  print(given.online, record::to_json(ExportedModel{id, given.out}),
        "model " + id + " written to " + given.out.string() + "\n");
  return kDone;
}

/// An event as a line of JSON shows it.
struct PrintedEvent {
  std::uint64_t seq = 0;
  std::string time, topic;
  json::object data;
};
void layout(record::Io& io, PrintedEvent& x) {
  io("seq", x.seq);
  io("time", x.time);
  io("topic", x.topic);
  io("data", x.data);
}

int print_events(const OnlineArguments& given, const json::object& params) {
  RpcClient client = value_or_throw(RpcClient::connect(given.online));
  const auto subscribed = value_or_throw(client.call_with<rpc::EventsSubscribe>(params));
  for (const auto& gap : subscribed.record.missing)
    print_to_stderr("truepose: events " + shown(gap.first) + " to " + shown(gap.last) +
                    " may be missing: " + shown(gap.reason));
  for (std::uint64_t seen = 0; !given.count || seen < *given.count; ++seen) {
    const control::Event event = value_or_throw(client.next_event());
    const PrintedEvent printed{event.seq, event.time, event.topic, event.data};
    print(given.online, record::to_json(printed), event_line(event) + "\n");
  }
  return kDone;
}

int call_method(const OnlineArguments& given, const json::object&) {
  const auto parsed = given.params.empty() ? json::object{} : control::parse_json(given.params);
  if (!parsed) throw CommandError{kBadInput, "call: JSON: " + parsed.error()};
  if (!parsed->is_object())
    throw CommandError{kBadInput, "call: JSON: expected an object, such as {\"limit\": 5}"};
  RpcClient client = value_or_throw(RpcClient::connect(given.online));
  print(json_line(value_or_throw(client.call(given.method, parsed->get_object()))));
  return kDone;
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
       "HOST:PORT is the daemon's TLS port; its certificate has to be from this CA (PEM)",
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
std::vector<OnlineRow> cell_rows() {
  return {
      asks<rpc::GetCellStatus>("status", "what the cell does, its devices, model, stream and faults", {}, status_text),
      asks<rpc::CellConnect>("connect", "connect robot and tracker", {}, status_text),
      asks<rpc::CellDisconnect>("disconnect", "let robot and tracker go", {}, status_text),
      asks<rpc::CellAcknowledge>("acknowledge", "clear a fault once its cause is gone, or let a stream that holds continue",
       {}, status_text),
  };
}

std::vector<OnlineRow> other_rows(OnlineArguments& a) {
  return {
      {"model", "", "the models that campaigns made"},
      asks<rpc::ModelList>("model list", "models, newest first", {}, models_text),
      asks<rpc::ModelGet>("model show", "one model with its parameters",
       {id_option(a, "model; default: the active one")}, model_text),
      asks<rpc::ModelActivate>("model activate", "let a model correct the arm", {id_option(a, "model", true)}, activated_text),
      asks<rpc::ModelRollback>("model rollback", "activate the model that was active before", {}, activated_text),
      asks<rpc::ModelDeactivate>("model deactivate", "let no model correct the arm", {}, deactivated_text),
      {"model export", "model.export", "write a model file",
       {id_option(a, "model; default: the active one"), {"--out", &a.out, "file; default: standard output",
       {.file = FileUse::Written}}},
       export_model},

      {"tools", "", "the measured tools that are in use"},
      asks<rpc::ToolList>("tools list", "the tools that are known by their numbers", {}, tools_text),
      asks<rpc::ToolActivate>("tools activate", "take the tool that a campaign measured into use, under its number",
       {id_option(a, "campaign", true)}, tool_in_use_text),
      asks<rpc::ToolDeactivate>("tools deactivate", "take it out of use again; one of the cell file stays",
       {{"NUMBER", &a.tool, "in TOOL_DATA", {.required = true, .key = "number"}}}, tool_out_of_use_text),

      {"stream", "", "correct the arm while it works"},
      asks<rpc::StreamStart>("stream start", "ramp the corrections in", {}, stream_text),
      asks<rpc::StreamStop>("stream stop", "ramp them out", {}, stream_text),
      asks<rpc::StreamArm>("stream arm", "correct every program that opens RSI, from now on", {}, stream_text),
      asks<rpc::StreamDisarm>("stream disarm", "ramp out what is corrected, and correct no other", {}, stream_text),
      asks<rpc::GetStreamStatus>("stream status", "counters of the stream", {}, stream_text),

      {"control", "", "who is in command"},
      asks<rpc::ControlGet>("control show", "who has control", {}, control_text),
      asks<rpc::ControlAcquire>("control acquire", "take control, or renew it",
       {{"--lease", &a.lease_s, "seconds until it ends unless it is renewed", {.key = "lease_s"}}}, control_text),
      asks<rpc::ControlTakeover>("control takeover", "take control from a lower role too",
       {{"--lease", &a.lease_s, "seconds until it ends unless it is renewed", {.key = "lease_s"}}}, control_text),
      asks<rpc::ControlRelease>("control release", "give control back", {}, control_text),

      {"audit", "", "what was commanded, and by whom"},
      asks<rpc::AuditList>("audit list", "commands, newest first",
       {{"--limit", &a.limit, "so many records at most", {.key = "limit"}}}, audit_text),
      asks<rpc::AuditAcknowledge>("audit acknowledge", "acknowledge that the audit trail was changed",
       {{"--name", &a.id, "of the person who has found out what happened", {.required = true, .key = "name"}}},
       acknowledged_text),

      {"recording", "", "what went over the wires to robot and tracker"},
      {"recording save", "recording.save", "write the last minutes to a file",
       {{"--out", &a.out, "file here; default: among the daemon's recordings alone",
       {.file = FileUse::Written}}},
       [](const OnlineArguments& x, const json::object&) { return save_recording(x.online, x.out); }},
      asks<rpc::RecordingList>("recording list", "recordings, newest first", {}, recordings_text),
      {"recording export", "recording.get", "copy a recording to a file",
       {{"NAME", &a.id, "recording", {.required = true}},
        {"--out", &a.out, "file", {.required = true, .file = FileUse::Written}}},
       [](const OnlineArguments& x, const json::object&) { return export_recording(x.online, x.id, x.out); }},

      {"backup", "store.backup", "copy the store while the daemon uses it",
       {{"--out", &a.out, "file here", {.required = true, .file = FileUse::Written}}},
       [](const OnlineArguments& x, const json::object&) { return back_up(x.online, x.out); }},

      {"events", "events.subscribe", "print what happens",
       {{"--topics", &a.topics, "cell, campaign, measurement, stream, model, fault, log, control", {.key = "topics"}},
        {"--after", &a.after, "number of the last event seen: what followed comes first", {.key = "after"}},
        {"--count", &a.count, "end after so many"}},
       print_events},
      {"call", "", "call any method of the daemon",
       {{"METHOD", &a.method, "such as cell.status", {.required = true}},
        {"JSON", &a.params, "its parameters, an object"}},
       call_method},
      {"report", "report.get", "errors before and after: a table, and a page to keep",
       {{"ID", &a.report.campaign, "campaign; default: the newest that is done"},
        {"--document", &a.report.document, "a calibration document (JSON) instead of the daemon's",
         {.excludes = {"ID", "--store"}, .file = FileUse::Read}},
        {"--store", &a.report.store, "the file of a store, or a copy of it, instead of a daemon",
         {.excludes = {"--daemon"}, .file = FileUse::Read}},
        {"--truth", &a.report.truth, "what a simulated arm really is (truepose-sim --truth-file)",
         {.file = FileUse::Read}},
        {"--path", &a.report.path,
         "what a production program did (truepose-sim --path-file), to be a section of the page",
         {.file = FileUse::Read}},
        {"--model", &a.report.model,
         "a model file by which --path is judged without a campaign; no daemon is needed",
         {.needs = {"--path", "--robot"},
          .excludes = {"ID", "--document", "--store", "--daemon", "--truth", "--iso9283", "--frame"},
          .file = FileUse::Read}},
        {"--robot", &a.report.robot, "the robot file from which --model was identified",
         {.needs = {"--model"}, .file = FileUse::Read}},
        {"--iso9283", &a.report.iso9283,
         "an ISO 9283 test (truepose iso9283 --json), to be a section of the page", {.file = FileUse::Read}},
        {"--frame", &a.report.frame,
         "a tool that was measured (truepose tool --json, or campaign export --document), to be a section of the page",
         {.file = FileUse::Read}},
        {"--html", &a.report.html, "write the page here", {.file = FileUse::Written}},
        {"--out-json", &a.report.json, "write the document here", {.file = FileUse::Written}}},
       [](const OnlineArguments& x, const json::object&) {
         return x.report.model.empty() ? report_campaign(x.online, x.report) : report_path(x.online, x.report);
       }},
  };
}
// clang-format on

// ---- From rows to commands ----

/// The value of an option as a parameter; nothing where the option is not given.
std::optional<json::value> parameter_of(const Option& option) {
  return std::visit(
      [&]<class T>(T* value) -> std::optional<json::value> {
        if constexpr (std::same_as<T, bool>) {
          return *value ? std::optional<json::value>{true} : std::nullopt;
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

Command command_of(const OnlineRow& row, const std::shared_ptr<OnlineArguments>& arguments) {
  Command command{.name = row.name, .help = row.help, .method = row.method};
  if (!row.run) return command;  // a group
  command.options = connection_options(arguments->online);
  command.options.push_back({"--json", &arguments->online.json, "print one JSON document"});
  command.options.insert(command.options.end(), row.options.begin(), row.options.end());
  command.run = [row, arguments] { return row.run(*arguments, parameters_of(row.options)); };
  return command;
}

}  // namespace

void print(const std::string& text) {
  std::fputs(text.c_str(), stdout);
  std::fflush(stdout);
}

void print(const OnlineOptions& online, const json::value& answer, const std::string& text) {
  print(online.json ? json_line(answer) : text);
}

Option id_option(OnlineArguments& arguments, const char* help, bool required) {
  return Option{"ID", &arguments.id, help, {.required = required, .key = "id"}};
}

CommandLine online_commands() {
  const auto arguments = std::make_shared<OnlineArguments>();
  CommandLine line{.options = connection_options(arguments->online), .commands = {}};
  for (const auto& rows : {cell_rows(), campaign_rows(*arguments), other_rows(*arguments)})
    for (const OnlineRow& row : rows) line.commands.push_back(command_of(row, arguments));
  return line;
}

}  // namespace truepose::tools
