#include "tools/truepose/online_commands.hpp"

#include <unistd.h>

#include <cstdio>

#include "config/text_file.hpp"
#include "proto/control/json_text.hpp"
#include "tools/truepose/campaign_files.hpp"
#include "tools/truepose/drift_text.hpp"
#include "tools/truepose/online_text.hpp"
#include "tools/truepose/rpc_client.hpp"

namespace truepose::tools {
namespace {

namespace json = boost::json;
using Render = std::string (*)(const json::value&);

int fail(const ClientError& error) {
  std::fprintf(stderr, "truepose: %s\n", error.message.c_str());
  return error.exit_code;
}

void print(const std::string& text) {
  std::fputs(text.c_str(), stdout);
  std::fflush(stdout);
}

void print_json(const json::value& value) { print(control::json_text(value) + "\n"); }

std::string member(const json::value& value, const char* pointer) {
  boost::system::error_code missing;
  const json::value* found = value.find_pointer(pointer, missing);
  return !missing && found->is_string() ? std::string{found->get_string()} : "";
}

/// Connects, calls once and prints the answer.
int ask(const OnlineOptions& online, const std::string& method, const json::object& params, Render render) {
  auto client = RpcClient::connect(online.daemon, online.token_file);
  if (!client) return fail(client.error());
  const auto result = client->call(method, params);
  if (!result) return fail(result.error());
  if (online.json) {
    print_json(*result);
  } else {
    print(render(*result));
  }
  return kDone;
}

json::object id_params(const std::string& id) {
  json::object params;
  if (!id.empty()) params["id"] = id;
  return params;
}

bool is_over(const std::string& phase) { return phase == "done" || phase == "aborted" || phase == "failed"; }

/// Shows progress: on a terminal one line that is written over, else a line each time.
class ProgressDisplay {
 public:
  explicit ProgressDisplay(bool silent) : silent_{silent}, overwrite_{::isatty(STDOUT_FILENO) == 1} {}
  void show(const json::value& progress) const {
    if (silent_) return;
    const bool last = is_over(member(progress, "/phase"));
    print((overwrite_ ? "\r\x1b[K" : "") + progress_line(progress) + (overwrite_ && !last ? "" : "\n"));
  }

 private:
  bool silent_;
  bool overwrite_;
};

/// Shows the progress of a campaign whose events this client already gets, until it is over.
/// @return its last progress
std::expected<json::value, ClientError> follow_progress(RpcClient& client, const std::string& id,
                                                        json::value progress, bool silent) {
  const ProgressDisplay display{silent};
  display.show(progress);
  while (!is_over(member(progress, "/phase"))) {
    const auto event = client.next_event();
    if (!event) return std::unexpected(event.error());
    json::value data = event->data;
    if (event->topic != "campaign" || member(data, "/id") != id) continue;
    progress = std::move(data);
    display.show(progress);
  }
  return progress;
}

/// Follows a campaign whose events this client already gets.
int follow(RpcClient& client, const OnlineOptions& online, const std::string& wanted) {
  const auto present = client.call("campaign.get", id_params(wanted));
  if (!present) return fail(present.error());
  const std::string id = member(*present, "/campaign/id");
  const json::value begun =
      present->as_object().contains("progress") ? present->at("progress") : json::value{};
  if (begun.is_null()) {  // over already
    const std::string state = member(*present, "/campaign/state");
    print(online.json ? control::json_text(*present) + "\n" : campaign_text(*present));
    return state == "done" ? kDone : kFailed;
  }
  const auto progress = follow_progress(client, id, begun, online.json);
  if (!progress) return fail(progress.error());
  if (online.json) print_json(*progress);
  return member(*progress, "/phase") == "done" ? kDone : kFailed;
}

std::expected<RpcClient, ClientError> connect_for_campaign(const OnlineOptions& online) {
  auto client = RpcClient::connect(online.daemon, online.token_file);
  if (!client) return client;
  // Before anything else, so that no event is missed.
  const auto subscribed = client->call("events.subscribe", {{"topics", json::array{"campaign"}}});
  if (!subscribed) return std::unexpected(subscribed.error());
  return client;
}

/// All points of a campaign, page by page.
std::expected<json::array, ClientError> all_points(RpcClient& client, const std::string& id) {
  json::array points;
  for (;;) {
    json::object params = id_params(id);
    params["points_offset"] = points.size();
    params["points_limit"] = 50;  // as many as surely fit into one line of the protocol
    const auto page = client.call("campaign.get", params);
    if (!page) return std::unexpected(page.error());
    const json::array& more = page->at("points").as_array();
    if (more.empty()) return points;
    points.insert(points.end(), more.begin(), more.end());
  }
}

/// @param kind  what the campaign must be to have the document: "targets", "iso9283"
std::expected<json::value, ClientError> document_of(const json::value& campaign, const std::string& kind) {
  const json::object& members = campaign.as_object();
  const json::value* document = members.if_contains(kind);
  if (document && !document->is_null()) return *document;
  return std::unexpected(ClientError{kFailed, "campaign " + member(campaign, "/campaign/id") +
                                                  " is not of kind " + kind + ", or is not done"});
}

std::expected<void, ClientError> write_files(RpcClient& client, const json::value& campaign,
                                             const CampaignFiles& files) {
  if (!files.joints.empty()) {
    const auto targets = document_of(campaign, "targets");
    if (!targets) return std::unexpected(targets.error());
    config::write_text_file(files.joints, joints_csv(*targets));
  }
  if (!files.cycles.empty()) {
    const auto iso9283 = document_of(campaign, "iso9283");
    if (!iso9283) return std::unexpected(iso9283.error());
    const auto points = all_points(client, member(campaign, "/campaign/id"));
    if (!points) return std::unexpected(points.error());
    config::write_text_file(files.cycles,
                            cycles_csv(*iso9283, member(campaign, "/campaign/started"), *points));
  }
  if (!files.document.empty()) {
    const auto document = document_of(campaign, member(campaign, "/campaign/kind"));
    if (!document) return std::unexpected(document.error());
    config::write_text_file(files.document, control::json_text(*document) + "\n");
  }
  return {};
}

}  // namespace

int status(const OnlineOptions& online) { return ask(online, "cell.status", {}, status_text); }
int connect_cell(const OnlineOptions& online) { return ask(online, "cell.connect", {}, status_text); }
int acknowledge_cell(const OnlineOptions& online) { return ask(online, "cell.acknowledge", {}, status_text); }

int campaign_start(const OnlineOptions& online, const CampaignStartOptions& start) {
  json::object params;
  if (!start.targets.empty()) params = targets_of_file(start.targets);
  if (start.kind != "calibration") params["kind"] = start.kind;
  if (start.rounds) params["rounds"] = *start.rounds;
  if (start.tolerance_mm) params["tolerance_mm"] = *start.tolerance_mm;
  if (start.readings) params["readings"] = *start.readings;
  if (start.cycles) params["cycles"] = *start.cycles;
  if (start.variation) params["variation"] = *start.variation;
  if (start.uncompensated) params["compensate"] = false;
  if (start.identify_poses) params["identify_poses"] = *start.identify_poses;
  if (start.validate_poses) params["validate_poses"] = *start.validate_poses;
  if (start.seed) params["seed"] = *start.seed;
  if (start.remeasure) params["remeasure"] = *start.remeasure;
  if (!start.activate) params["activate"] = false;
  if (!start.watch)
    return ask(online, "campaign.start", params, [](const json::value& started) {
      return "campaign " + member(started, "/id") + " runs; follow it with: truepose campaign watch\n";
    });
  auto client = connect_for_campaign(online);
  if (!client) return fail(client.error());
  const auto started = client->call("campaign.start", params);
  if (!started) return fail(started.error());
  const std::string id = member(*started, "/id");
  const int exit_code = follow(*client, online, id);
  // A calibration has its report; what the others found is short.
  if (exit_code != kDone || online.json || start.kind == "calibration") return exit_code;
  return ask(online, "campaign.get", id_params(id), campaign_text);
}

int campaign_control(const OnlineOptions& online, const std::string& action) {
  return ask(online, "campaign." + action, {},
             [](const json::value& progress) { return progress_line(progress) + "\n"; });
}

int campaign_list(const OnlineOptions& online) { return ask(online, "campaign.list", {}, campaigns_text); }

int campaign_show(const OnlineOptions& online, const std::string& id, const CampaignFiles& files) {
  auto client = RpcClient::connect(online.daemon, online.token_file);
  if (!client) return fail(client.error());
  const auto found = client->call("campaign.get", id_params(id));
  if (!found) return fail(found.error());
  const auto written = write_files(*client, *found, files);
  if (!written) return fail(written.error());
  online.json ? print_json(*found) : print(campaign_text(*found));
  return kDone;
}

int campaign_watch(const OnlineOptions& online, const std::string& id) {
  auto client = connect_for_campaign(online);
  if (!client) return fail(client.error());
  return follow(*client, online, id);
}

int check_drift(const OnlineOptions& online) {
  auto client = connect_for_campaign(online);
  if (!client) return fail(client.error());
  const auto started = client->call("drift.check", {});
  if (!started) return fail(started.error());
  const std::string id = member(*started, "/id");
  auto found = client->call("campaign.get", id_params(id));
  if (found && !found->at("progress").is_null()) {
    const auto ended = follow_progress(*client, id, found->at("progress"), online.json);
    if (!ended) return fail(ended.error());
    found = client->call("campaign.get", id_params(id));
  }
  if (!found) return fail(found.error());
  const json::value& document = found->at("drift");
  if (document.is_null()) {
    std::fprintf(stderr, "truepose: the drift check %s: %s\n", member(*found, "/campaign/state").c_str(),
                 member(*found, "/campaign/reason").c_str());
    return kFailed;
  }
  online.json ? print_json(document) : print("\n" + drift_text(document));
  return member(document, "/verdict") == "failed" ? kFailed : kDone;
}

int model_list(const OnlineOptions& online) { return ask(online, "model.list", {}, models_text); }

int model_show(const OnlineOptions& online, const std::string& id) {
  return ask(online, "model.get", id_params(id), model_text);
}

int model_activate(const OnlineOptions& online, const std::string& id) {
  return ask(online, "model.activate", id_params(id),
             [](const json::value& model) { return "model " + member(model, "/id") + " is active\n"; });
}

int model_deactivate(const OnlineOptions& online) {
  return ask(online, "model.deactivate", {}, [](const json::value& result) {
    const std::string id = member(result, "/deactivated");
    return id.empty() ? std::string{"no model was active\n"} : "model " + id + " is no longer active\n";
  });
}

int model_export(const OnlineOptions& online, const std::string& id, const std::filesystem::path& out) {
  if (out.empty())
    return ask(online, "model.export", id_params(id),
               [](const json::value& model) { return member(model, "/yaml"); });
  auto client = RpcClient::connect(online.daemon, online.token_file);
  if (!client) return fail(client.error());
  const auto model = client->call("model.export", id_params(id));
  if (!model) return fail(model.error());
  config::write_text_file(out, member(*model, "/yaml"));
  if (online.json) {
    print_json({{"id", member(*model, "/id")}, {"file", out.string()}});
  } else {
    print("model " + member(*model, "/id") + " written to " + out.string() + "\n");
  }
  return kDone;
}

int stream_control(const OnlineOptions& online, const std::string& action) {
  return ask(online, "stream." + action, {}, stream_text);
}

int events(const OnlineOptions& online, const EventsOptions& options) {
  auto client = RpcClient::connect(online.daemon, online.token_file);
  if (!client) return fail(client.error());
  json::object params;
  if (!options.topics.empty()) params["topics"] = json::array(options.topics.begin(), options.topics.end());
  if (options.after) params["after"] = *options.after;
  const auto subscribed = client->call("events.subscribe", params);
  if (!subscribed) return fail(subscribed.error());
  if (const json::value* complete = subscribed->as_object().if_contains("complete");
      complete && *complete == false)
    std::fprintf(stderr, "truepose: some events since number %lld are no longer kept\n",
                 static_cast<long long>(options.after.value_or(0)));
  for (std::uint64_t seen = 0; !options.count || seen < *options.count; ++seen) {
    const auto event = client->next_event();
    if (!event) return fail(event.error());
    if (online.json) {
      print_json(
          {{"seq", event->seq}, {"time", event->time}, {"topic", event->topic}, {"data", event->data}});
    } else {
      print(event_line(*event) + "\n");
    }
  }
  return kDone;
}

int call_method(const OnlineOptions& online, const std::string& method, const std::string& params) {
  json::object object;
  if (!params.empty()) {
    auto parsed = control::parse_json(params);
    if (!parsed) return fail({kBadInput, "call: JSON: " + parsed.error()});
    if (!parsed->is_object())
      return fail({kBadInput, "call: JSON: expected an object, such as {\"limit\": 5}"});
    object = std::move(parsed->get_object());
  }
  return ask(online, method, object,
             [](const json::value& result) { return control::json_text(result) + "\n"; });
}

}  // namespace truepose::tools
