#include <algorithm>
#include <boost/asio/co_spawn.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/use_future.hpp>
#include <memory>

#include "config/number_text.hpp"
#include "proto/control/json_text.hpp"
#include "proto/record/json_io.hpp"
#include "tools/truepose/bridge/conformance.hpp"
#include "tools/truepose/offline/offline_commands.hpp"
#include "tools/truepose/online/online_commands.hpp"
#include "tools/truepose/text.hpp"

namespace truepose::tools {

void layout(record::Io& io, BridgeVerdict& x) {
  io("promise", x.promise);
  io("outcome", x.outcome, kConformances);
  io("found", x.found);
  io("next", x.next);
}

namespace {

namespace asio = boost::asio;

struct BridgeCheckCommand {
  std::string where;
  std::vector<double> at_mm;
  double search_mm = 50;
  int measure_ms = 2000;
  bool json = false;
};

BridgeCheckOptions options_of(const BridgeCheckCommand& command) {
  const auto endpoint = config::parse_endpoint(command.where);
  if (!endpoint) throw bad_usage("bridge-check: " + endpoint.error());
  BridgeCheckOptions options{.host = endpoint->host,
                             .port = endpoint->port,
                             .search_mm = command.search_mm,
                             .measure = std::chrono::milliseconds{command.measure_ms}};
  if (!command.at_mm.empty())
    options.reflector_mm = Eigen::Vector3d{command.at_mm[0], command.at_mm[1], command.at_mm[2]};
  return options;
}

std::vector<BridgeVerdict> examined(const BridgeCheckCommand& command) {
  asio::io_context io;
  drivers::SteadyClock clock;
  auto verdicts =
      asio::co_spawn(io, check_bridge(io.get_executor(), clock, options_of(command)), asio::use_future);
  io.run();
  auto result = verdicts.get();
  if (!result) throw CommandError{kUnreachable, "bridge-check: " + result.error()};
  return *std::move(result);
}

std::string verdicts_text(const std::vector<BridgeVerdict>& verdicts) {
  std::vector<Cells> rows;
  for (const BridgeVerdict& one : verdicts) {
    const std::string found = one.found.empty() ? "" : ": " + one.found;
    const std::string next = one.next.empty() ? "" : "; next: " + one.next;
    rows.push_back({std::string{name_of(kConformances, one.outcome)}, one.promise + found + next});
  }
  return text_table(rows);
}

int run_bridge_check(const BridgeCheckCommand& command) {
  const std::vector<BridgeVerdict> verdicts = examined(command);
  print(command.json ? control::json_text(record::to_json(verdicts)) + "\n" : verdicts_text(verdicts));
  return std::ranges::count(verdicts, Conformance::Failed, &BridgeVerdict::outcome) > 0 ? kFailed : kDone;
}

}  // namespace

Command bridge_check_command() {
  const auto command = std::make_shared<BridgeCheckCommand>();
  BridgeCheckCommand& c = *command;
  return {.name = "bridge-check",
          .help = "Tries every promise of a tracker's bridge (docs/trackers.md)",
          .options = {Option("bridge", &c.where, "Where the bridge listens",
                             {.required = true, .type = "HOST:PORT"}),
                      Option("--at", &c.at_mm,
                             "Where a reflector stands (mm, tracker frame); without it the tracker is not "
                             "moved, and what needs that is skipped",
                             {.type = "X,Y,Z", .count = 3}),
                      Option("--search", &c.search_mm, "Radius around it that is searched",
                             {.shows_default = true, .check = in_range(1.0, 5000.0), .type = "MM"}),
                      Option("--measure-ms", &c.measure_ms, "Duration of one measurement",
                             {.shows_default = true, .check = in_range(1, 60'000), .type = "MS"}),
                      Option("--json", &c.json,
                             "Print one JSON document: a list of {promise, outcome, found, next}")},
          .run = [command] { return run_bridge_check(*command); },
          .task = Task::Diagnosis,
          .examples = {{"bridge-check 127.0.0.1:7300 --at 2000,0,1000"}}};
}

}  // namespace truepose::tools
