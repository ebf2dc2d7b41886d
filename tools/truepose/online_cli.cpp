#include "tools/truepose/online_cli.hpp"

#include <CLI/CLI.hpp>
#include <functional>
#include <memory>

#include "tools/truepose/online_commands.hpp"
#include "tools/truepose/report_command.hpp"

namespace truepose::tools {
namespace {

/// Everything that options are read into; lives as long as the commands that refer to it.
struct Arguments {
  OnlineOptions online;
  CampaignStartOptions start;
  bool no_activate = false;
  CampaignFiles files;
  EventsOptions events;
  ReportOptions report;
  std::string id;
  std::filesystem::path out;
  std::string method, params;
};

/// --NAME and --no-NAME; `choose` is called with the one that is given, if any.
void add_choice(CLI::App& to, const std::string& name, const std::string& what,
                const std::function<void(bool)>& choose) {
  CLI::Option* yes = to.add_flag_callback(
      "--" + name, [choose] { choose(true); }, what);
  to.add_flag_callback(
        "--no-" + name, [choose] { choose(false); }, "do not")
      ->excludes(yes);
}

}  // namespace

void add_online_commands(CLI::App& app, int& exit_code) {
  const auto arguments = std::make_shared<Arguments>();
  Arguments& a = *arguments;

  // Before the command or after it.
  const auto add_connection = [&](CLI::App& to) {
    to.add_option(
        "--daemon", a.online.daemon,
        "HOST:PORT of the daemon, or the path of its control socket; default: the control socket of the one "
        "that runs here, else 127.0.0.1:7210");
    to.add_option("--token-file", a.online.token_file, "file with the daemon's token, for HOST:PORT")
        ->envname("TRUEPOSE_TOKEN_FILE");
  };
  add_connection(app);
  const auto command = [&](CLI::App& parent, const std::string& name, const std::string& text,
                           std::function<int(const Arguments&)> run) {
    CLI::App* sub = parent.add_subcommand(name, text);
    add_connection(*sub);
    sub->add_flag("--json", arguments->online.json, "print one JSON document");
    sub->callback([arguments, run = std::move(run), &exit_code] { exit_code = run(*arguments); });
    return sub;
  };
  const auto group = [&](const std::string& name, const std::string& text) -> CLI::App& {
    return *app.add_subcommand(name, text)->require_subcommand(1);
  };

  command(app, "status", "what the cell does, its devices, model, stream and faults",
          [](const Arguments& x) { return status(x.online); });
  command(app, "connect", "connect robot and tracker",
          [](const Arguments& x) { return connect_cell(x.online); });
  command(app, "acknowledge", "clear a fault whose cause is gone, or let a stream that holds go on",
          [](const Arguments& x) { return acknowledge_cell(x.online); });

  CLI::App& campaign = group("campaign", "measure and identify the arm");
  CLI::App* start = command(campaign, "start", "start a campaign", [](const Arguments& x) {
    CampaignStartOptions options = x.start;
    options.activate = !x.no_activate;
    return campaign_start(x.online, options);
  });
  start->add_option("--kind", a.start.kind, "what to measure for")
      ->check(CLI::IsMember({"calibration", "targets", "iso9283"}))
      ->capture_default_str();
  start->add_option(
      "--targets", a.start.targets,
      "targets (CSV: q1..qN in deg, or x,y,z,a,b,c of the flange); default: validation poses of a plan");
  start->add_option("--rounds", a.start.rounds, "corrections of a target at most");
  start->add_option("--tolerance", a.start.tolerance_mm, "mm to which the mean of its readings must come");
  start->add_option("--readings", a.start.readings, "of the tracker in each round");
  start->add_option("--cycles", a.start.cycles, "of an ISO 9283 test; default as configured");
  add_choice(
      *start, "variation",
      "ISO 9283: come to P1, P2 and P4 along the three axes of the base too, for vAP; default as configured",
      [arguments](bool yes) { arguments->start.variation = yes; });
  start->add_flag("--uncompensated", a.start.uncompensated, "ISO 9283 of the nominal arm; needs no model");
  start->add_option("--identify", a.start.identify_poses, "poses to identify from");
  start->add_option("--validate", a.start.validate_poses, "poses to validate on");
  start->add_option("--seed", a.start.seed, "seed of the planner");
  add_choice(*start, "remeasure",
             "measure the validation poses again with compensated joints; default as configured",
             [arguments](bool yes) { arguments->start.remeasure = yes; });
  start->add_flag("--no-activate", a.no_activate, "keep the model inactive");
  start->add_flag("--watch", a.start.watch, "follow it to its end");
  for (const std::string action : {"pause", "resume", "abort"})
    command(campaign, action, action + " the campaign that runs",
            [action](const Arguments& x) { return campaign_control(x.online, action); });
  command(campaign, "list", "campaigns, newest first",
          [](const Arguments& x) { return campaign_list(x.online); });
  CLI::App* show = command(campaign, "show", "one campaign",
                           [](const Arguments& x) { return campaign_show(x.online, x.id, x.files); });
  show->add_option("ID", a.id, "campaign; default: the newest");
  show->add_option("--joints", a.files.joints, "write the joints that were found for targets here (CSV)");
  show->add_option("--cycles", a.files.cycles,
                   "write the cycles of an ISO 9283 test here (CSV), as truepose iso9283 --data reads them");
  show->add_option(
      "--document", a.files.document,
      "write what it found here (JSON); of an ISO 9283 test, as truepose report --iso9283 reads it");
  command(campaign, "watch", "follow a campaign to its end", [](const Arguments& x) {
    return campaign_watch(x.online, x.id);
  })->add_option("ID", a.id, "campaign; default: the newest");

  CLI::App& model = group("model", "the models that campaigns made");
  command(model, "list", "models, newest first", [](const Arguments& x) { return model_list(x.online); });
  command(model, "show", "one model with its parameters", [](const Arguments& x) {
    return model_show(x.online, x.id);
  })->add_option("ID", a.id, "model; default: the active one");
  command(model, "activate", "let a model correct the arm",
          [](const Arguments& x) { return model_activate(x.online, x.id); })
      ->add_option("ID", a.id, "model")
      ->required();
  command(model, "deactivate", "let no model correct the arm",
          [](const Arguments& x) { return model_deactivate(x.online); });
  CLI::App* export_model = command(model, "export", "write a model file",
                                   [](const Arguments& x) { return model_export(x.online, x.id, x.out); });
  export_model->add_option("ID", a.id, "model; default: the active one");
  export_model->add_option("--out", a.out, "file; default: standard output");

  CLI::App& stream = group("stream", "correct the arm while it works");
  for (const auto& [action, text] : {std::pair{"start", "ramp the corrections in"},
                                     {"stop", "ramp them out"},
                                     {"status", "counters of the stream"}})
    command(stream, action, text,
            [name = std::string{action}](const Arguments& x) { return stream_control(x.online, name); });

  CLI::App* listen = command(app, "events", "print what happens",
                             [](const Arguments& x) { return events(x.online, x.events); });
  listen->add_option("--topics", a.events.topics, "cell, campaign, measurement, stream, model, fault, log")
      ->delimiter(',');
  listen->add_option("--after", a.events.after, "number of the last event seen: what followed comes first");
  listen->add_option("--count", a.events.count, "end after so many");

  CLI::App* call = command(app, "call", "call any method of the daemon",
                           [](const Arguments& x) { return call_method(x.online, x.method, x.params); });
  call->add_option("METHOD", a.method, "such as cell.status")->required();
  call->add_option("JSON", a.params, "its parameters, an object");

  CLI::App* report = command(app, "report", "errors before and after: a table, and a page to keep",
                             [](const Arguments& x) { return report_campaign(x.online, x.report); });
  CLI::Option* campaign_id =
      report->add_option("ID", a.report.campaign, "campaign; default: the newest that is done");
  report->add_option("--document", a.report.document, "a calibration document (JSON) instead of the daemon's")
      ->excludes(campaign_id);
  report->add_option("--truth", a.report.truth, "what a simulated arm really is (truepose-sim --truth-file)");
  report->add_option("--iso9283", a.report.iso9283,
                     "an ISO 9283 test (truepose iso9283 --json), to be a section of the page");
  report->add_option("--experiment", a.report.experiment,
                     "an experiment (truepose experiment --json), to be sections of the page");
  report->add_option("--html", a.report.html, "write the page here");
  report->add_option("--out-json", a.report.json, "write the document here");
}

}  // namespace truepose::tools
