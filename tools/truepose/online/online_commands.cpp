#include "tools/truepose/online/online_commands.hpp"

#include <algorithm>
#include <boost/json/object.hpp>
#include <boost/json/value_from.hpp>
#include <cstdio>
#include <map>
#include <memory>
#include <type_traits>

#include "config/text_file.hpp"
#include "proto/control/json_text.hpp"
#include "proto/rpc/events.hpp"
#include "tools/truepose/online/backup_command.hpp"
#include "tools/truepose/online/id_lookup.hpp"
#include "tools/truepose/online/online_row.hpp"
#include "tools/truepose/online/online_text.hpp"
#include "tools/truepose/online/path_report.hpp"
#include "tools/truepose/online/recording_commands.hpp"
#include "tools/truepose/text.hpp"

namespace truepose::tools {
namespace {

// ---- Texts of one sentence ----

std::string activated_text(const rpc::ModelSummary& model) {
  const std::string warning = model.warning ? "warning: " + *model.warning + "\n" : "";
  return "model " + model.id + " is active\n" + warning;
}

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
  const auto patience = given.timeout_s.transform([](double s) { return std::chrono::duration<double>{s}; });
  for (std::uint64_t seen = 0; !given.count || seen < *given.count; ++seen) {
    const control::Event event = value_or_throw(client.next_event(patience));
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

/// What a shell offers for an id.
std::function<std::vector<std::string>()> ids_of(const OnlineArguments& arguments, const char* of) {
  return [&arguments, of] { return ids_to_choose(arguments.online, of); };
}

std::vector<Option> connection_options(OnlineOptions& online) {
  return {
      {"--daemon",
       &online.daemon,
       "HOST:PORT of the daemon, or the path of its control socket; default: the control socket of the one "
       "that runs here, else 127.0.0.1:7210",
       {.type = "HOST:PORT", .environment = "TRUEPOSE_DAEMON"}},
      {"--token-file",
       &online.token_file,
       "File with the daemon's token, for HOST:PORT",
       {.environment = "TRUEPOSE_TOKEN_FILE", .file = FileUse::Read}},
      {"--tls-ca",
       &online.tls.ca,
       "HOST:PORT is the daemon's TLS port; its certificate has to be from this CA (PEM)",
       {.environment = "TRUEPOSE_TLS_CA", .file = FileUse::Read}},
      {"--cert",
       &online.tls.certificate,
       "Certificate to be known by (PEM) instead of a token",
       {.needs = {"--tls-ca", "--key"}, .file = FileUse::Read}},
      {"--key",
       &online.tls.key,
       "Private key of --cert (PEM)",
       {.needs = {"--cert"}, .file = FileUse::Read}}};
}

// clang-format off
std::vector<OnlineRow> cell_rows() {
  return {
      asks<rpc::GetCellStatus>("status", "What the cell does, its devices, model, stream and faults", {}, status_text),
      asks<rpc::CellConnect>("connect", "Connect robot and tracker", {}, status_text),
      asks<rpc::CellDisconnect>("disconnect", "Let robot and tracker go", {}, status_text),
      asks<rpc::CellAcknowledge>("acknowledge", "Clear a fault once its cause is gone, or let a stream that holds continue",
       {}, status_text),
  };
}

std::vector<OnlineRow> other_rows(OnlineArguments& a) {
  return {
      {"model", "", "The models that campaigns made"},
      asks<rpc::ModelList>("model list", "Models, newest first", {}, models_text),
      asks<rpc::ModelGet>("model show", "One model with its parameters",
       {id_option(a, "model", "Model; default: the active one")}, model_text,
       {{"model show"}, {"model show 3f2a"}}),
      asks<rpc::ModelActivate>("model activate", "Let a model correct the arm", {id_option(a, "model", "Model", true)}, activated_text,
       {{"model activate latest"}}),
      asks<rpc::ModelRollback>("model rollback", "Activate the model that was active before", {}, activated_text),
      asks<rpc::ModelDeactivate>("model deactivate", "Let no model correct the arm", {}, deactivated_text),
      {"model export", "model.export", "Write a model file",
       {id_option(a, "model", "Model; default: the active one"), {"--out", &a.out, "File to write; default: standard output",
       {.file = FileUse::Written}}},
       export_model,
       {{"model export -o model.yaml"}}},

      {"tools", "", "The measured tools that are in use"},
      asks<rpc::ToolList>("tools list", "The tools that are known by their numbers", {}, tools_text),
      asks<rpc::ToolActivate>("tools activate", "Take the tool that a campaign measured into use, under its number",
       {id_option(a, "campaign", "Campaign", true)}, tool_in_use_text, {{"tools activate latest"}}),
      asks<rpc::ToolDeactivate>("tools deactivate", "Take it out of use again; one of the cell file stays",
       {{"NUMBER", &a.tool, "Its number in TOOL_DATA", {.required = true, .key = "number"}}}, tool_out_of_use_text,
       {{"tools deactivate 3"}}),

      {"stream", "", "Correct the arm while it works"},
      asks<rpc::StreamStart>("stream start", "Ramp the corrections in", {}, stream_text),
      asks<rpc::StreamStop>("stream stop", "Ramp them out", {}, stream_text),
      asks<rpc::StreamArm>("stream arm", "Correct every program that opens RSI, from now on", {}, stream_text),
      asks<rpc::StreamDisarm>("stream disarm", "Ramp out what is corrected, and correct no other", {}, stream_text),
      asks<rpc::GetStreamStatus>("stream status", "Counters of the stream", {}, stream_text),

      {"control", "", "Who is in command"},
      asks<rpc::ControlGet>("control show", "Who has control", {}, control_text),
      asks<rpc::ControlAcquire>("control acquire", "Take control, or renew it",
       {{"--lease", &a.lease_s, "Seconds until it ends unless it is renewed", {.key = "lease_s"}}}, control_text),
      asks<rpc::ControlTakeover>("control takeover", "Take control from a lower role too",
       {{"--lease", &a.lease_s, "Seconds until it ends unless it is renewed", {.key = "lease_s"}}}, control_text),
      asks<rpc::ControlRelease>("control release", "Give control back", {}, control_text),

      {"audit", "", "What was commanded, and by whom"},
      asks<rpc::AuditList>("audit list", "Commands, newest first",
       {{"--limit", &a.limit, "So many records at most", {.key = "limit"}}}, audit_text),
      asks<rpc::AuditAcknowledge>("audit acknowledge", "Acknowledge that the audit trail was changed",
       {{"--name", &a.id, "Name of the person who has found out what happened", {.required = true, .key = "name"}}},
       acknowledged_text, {{"audit acknowledge --name 'Anna Beer'"}}),

      {"recording", "", "What went over the wires to robot and tracker"},
      {"recording save", "recording.save", "Write the last minutes to a file",
       {{"--out", &a.out, "File to write here; default: among the daemon's recordings alone",
       {.file = FileUse::Written}}},
       [](const OnlineArguments& x, const json::object&) { return save_recording(x.online, x.out); },
       {{"recording save -o last.pcapng"}}},
      asks<rpc::RecordingList>("recording list", "Recordings, newest first", {}, recordings_text),
      {"recording export", "recording.get", "Copy a recording to a file",
       {{"NAME", &a.id, "Recording", {.required = true, .id_of = "recording", .candidates = ids_of(a, "recording")}},
        {"--out", &a.out, "File to write", {.required = true, .file = FileUse::Written}}},
       [](const OnlineArguments& x, const json::object&) { return export_recording(x.online, x.id, x.out); },
       {{"recording export latest -o last.pcapng"}}},

      {"backup", "store.backup", "Copy the store while the daemon uses it",
       {{"--out", &a.out, "File to write", {.required = true, .file = FileUse::Written}}},
       [](const OnlineArguments& x, const json::object&) { return back_up(x.online, x.out); },
       {{"backup -o store.backup"}}},

      {"events", "events.subscribe", "Print what happens",
       {{"--topics", &a.topics, "Any of cell, campaign, measurement, stream, model, fault, log, control", {.key = "topics"}},
        {"--after", &a.after, "Number of the last event seen: what followed comes first", {.key = "after"}},
        {"--count", &a.count, "End after so many"},
        {"--timeout", &a.timeout_s, "End with 1 where none comes within so many seconds", {.check = in_range(0.1, 86'400.0), .type = "S"}}},
       print_events,
       {{"events --topics campaign,fault"}}},
      {"call", "", "Call any method of the daemon",
       {{"METHOD", &a.method, "Such as cell.status", {.required = true}},
        {"JSON", &a.params, "Its parameters, an object"}},
       call_method,
       {{"call cell.status"}, {"call campaign.list '{\"limit\": 5}'"}}},
      {"report", "report.get", "Errors before and after: a table, and a page to keep",
       {{"ID", &a.report.campaign, "Campaign; default: the newest that is done", {.id_of = "campaign", .candidates = ids_of(a, "campaign")}},
        {"--document", &a.report.document, "A calibration document (JSON) instead of the daemon's",
         {.excludes = {"ID", "--store"}, .file = FileUse::Read}},
        {"--store", &a.report.store, "The file of a store, or a copy of it, instead of a daemon",
         {.excludes = {"--daemon"}, .file = FileUse::Read}},
        {"--truth", &a.report.truth, "What a simulated arm really is (truepose-sim --truth-file)",
         {.file = FileUse::Read}},
        {"--path", &a.report.path,
         "What a production program did (truepose-sim --path-file), to be a section of the page",
         {.file = FileUse::Read}},
        {"--model", &a.report.model,
         "A model file by which --path is judged without a campaign; no daemon is needed",
         {.needs = {"--path", "--robot"},
          .excludes = {"ID", "--document", "--store", "--daemon", "--truth", "--iso9283", "--frame"},
          .file = FileUse::Read}},
        {"--robot", &a.report.robot, "The robot file from which --model was identified",
         {.needs = {"--model"}, .file = FileUse::Read}},
        {"--iso9283", &a.report.iso9283,
         "An ISO 9283 test (truepose iso9283 --json), to be a section of the page", {.file = FileUse::Read}},
        {"--frame", &a.report.frame,
         "A tool that was measured (truepose tool --json, or campaign export --document), to be a section of the page",
         {.file = FileUse::Read}},
        {"--html", &a.report.html, "Write the page here", {.file = FileUse::Written}},
        {"--out-json", &a.report.json, "Write the document here", {.file = FileUse::Written}}},
       [](const OnlineArguments& x, const json::object&) {
         return x.report.model.empty() ? report_campaign(x.online, x.report) : report_path(x.online, x.report);
       },
       {{"report --html report.html", "The newest campaign that is done"},
        {"report 3f2a --html report.html --iso9283 iso9283.json"}}},
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

/// Puts whole ids in the place of their starts and of "latest".
void complete_ids(const std::vector<Option>& options, const OnlineArguments& given) {
  const StoreFile store{given.store.store.empty() ? given.report.store : given.store.store, {}};
  for (const Option& option : options) {
    if (option.rules.id_of.empty()) continue;
    std::string& id = *std::get<std::string*>(option.target);
    if (!id.empty()) id = whole_id(given.online, store, option.rules.id_of, id);
  }
}

Task task_of(const std::string& command) {
  const auto is_one_of = [&](std::initializer_list<std::string_view> names) {
    return std::ranges::find(names, command) != names.end();
  };
  if (is_one_of({"control", "audit", "backup"})) return Task::Cell;
  if (is_one_of({"recording", "events", "call"})) return Task::Diagnosis;
  return Task::Daemon;
}

Command command_of(const OnlineRow& row, const std::shared_ptr<OnlineArguments>& arguments) {
  Command command{.name = row.name,
                  .help = row.help,
                  .method = row.method,
                  .task = task_of(row.name),
                  .examples = row.examples};
  if (!row.run) return command;  // a group
  command.options = connection_options(arguments->online);
  command.options.push_back({"--json", &arguments->online.json, "One JSON document"});
  command.options.insert(command.options.end(), row.options.begin(), row.options.end());
  command.run = [row, arguments] {
    complete_ids(row.options, *arguments);
    return row.run(*arguments, parameters_of(row.options));
  };
  return command;
}

}  // namespace

std::string command_calling(const std::string& method) {
  static const std::map<std::string, std::string> commands = [] {
    std::map<std::string, std::string> by_method{{"drift.check", "drift"}};  // which works on files too
    for (const Command& command : online_commands().commands) by_method.emplace(command.method, command.name);
    return by_method;
  }();
  const auto found = commands.find(method);
  return found == commands.end() ? "" : found->second;
}

void print(const std::string& text) {
  std::fputs(text.c_str(), stdout);
  std::fflush(stdout);
}

void print(const OnlineOptions& online, const json::value& answer, const std::string& text) {
  print(online.json ? json_line(answer) : text);
}

Option id_option(OnlineArguments& arguments, const char* of, const char* help, bool required) {
  return Option{"ID",
                &arguments.id,
                help,
                {.required = required, .key = "id", .id_of = of, .candidates = ids_of(arguments, of)}};
}

CommandLine online_commands() {
  const auto arguments = std::make_shared<OnlineArguments>();
  CommandLine line{.options = connection_options(arguments->online), .commands = {}};
  for (const auto& rows : {cell_rows(), campaign_rows(*arguments), other_rows(*arguments)})
    for (const OnlineRow& row : rows) line.commands.push_back(command_of(row, arguments));
  return line;
}

}  // namespace truepose::tools
