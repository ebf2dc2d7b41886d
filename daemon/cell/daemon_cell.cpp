#include "daemon/cell/daemon_cell.hpp"

#include <algorithm>
#include <boost/asio/experimental/awaitable_operators.hpp>
#include <utility>

#include "proto/control/json_text.hpp"

namespace truepose::daemon {

namespace asio = boost::asio;
namespace json = boost::json;
using namespace std::chrono_literals;

DaemonCell::DaemonCell(Parts parts)
    : parts_{std::move(parts)},
      runner_{parts_.clock,
              parts_.events,
              parts_.wall_clock,
              {.campaign_waiting = parts_.config.campaign.pause_after}},
      store_{parts_, runner_},
      devices_{parts_, runner_, store_, [this] { return status(); }},
      tools_{parts_, runner_, devices_},
      models_{parts_, runner_, store_, devices_, tools_},
      targets_{parts_, models_},
      stream_{parts_, runner_, store_, devices_, models_},
      recording_{parts_, runner_, devices_, models_},
      campaigns_{parts_, runner_, store_, devices_, models_},
      archive_{parts_, [this] { return campaigns_.current(); }},
      reports_{parts_, [this] { return record::to_json(stream_.status()); }},
      identifications_{parts_, runner_, store_, models_},
      backups_{parts_} {
  runner_.possible_where([this](std::string_view method) {
    if (method == "stream.start" || method == "stream.arm") return models_.needed_to_correct().has_value();
    if (method == "drift.check") return models_.needed_for_drift().has_value();
    return true;
  });
  add_methods(table_, devices_);
  add_methods(table_, tools_);
  add_methods(table_, models_);
  add_methods(table_, targets_);
  add_methods(table_, stream_);
  add_methods(table_, recording_);
  add_methods(table_, campaigns_);
  add_methods(table_, archive_);
  add_methods(table_, reports_);
  add_methods(table_, identifications_);
  add_methods(table_, backups_);
}

std::vector<std::string> DaemonCell::method_names() {
  std::vector<std::string> names;
  const auto add = [&names](const auto& methods) {
    for (const auto& method : methods) names.emplace_back(method.name);
  };
  add(DeviceService::methods());
  add(ToolService::methods());
  add(ModelService::methods());
  add(TargetService::methods());
  add(StreamService::methods());
  add(RecordingService::methods());
  add(CampaignService::methods());
  add(CampaignArchive::methods());
  add(ReportService::methods());
  add(IdentificationService::methods());
  add(BackupService::methods());
  return names;
}

MethodReply DaemonCell::call(std::string method, json::object params, std::string by) {
  const auto known = table_.find(method);
  if (known == table_.end())
    co_return std::unexpected(
        control::RpcError{control::ErrorCode::MethodNotFound, "no such method: " + method});
  if (runner_.rules_out(FaultCode::Store, method)) co_return std::unexpected(store_.refusal());
  MethodResult result = co_await known->second(std::move(params), std::move(by));
  co_return result;
}

MethodReply DaemonCell::pause(std::string why, std::string by) {
  const auto paused = campaigns_.pause_because(why, by);
  if (!paused) co_return std::unexpected(paused.error());
  co_return record::to_json(*paused);
}

asio::awaitable<void> DaemonCell::watch() {
  using namespace asio::experimental::awaitable_operators;
  co_await (runner_.watch() && store_.watch() && stream_.watch() && devices_.watch() && recording_.watch());
}

asio::awaitable<void> DaemonCell::shut_down() {
  parts_.stream.disengage();
  campaigns_.interrupt("the daemon was stopped");
  const TimePoint give_up = parts_.clock.now() + parts_.config.stream.ramp + 5s;
  while ((stream_.in_effect() || campaigns_.running()) && parts_.clock.now() < give_up)
    co_await runner_.changed_until(give_up);
  if (runner_.streaming()) co_await devices_.stop_robot();
  devices_.disconnect();
}

DaemonCell::Snapshot DaemonCell::snapshot() const {
  const WatchedRobot& robot = devices_.robot();
  return {.state = runner_.name(),
          .warnings = runner_.faults().count("warning"),
          .errors = runner_.faults().count("error"),
          .robot_connected = robot.connected(),
          .robot_ready = robot.connected() && robot.last_state() && robot.last_state()->ready,
          .tracker_connected = devices_.tracker().connected(),
          .armed = runner_.armed(),
          .campaign = campaigns_.progress(),
          .model = models_.active() ? std::optional{models_.active()->record} : std::nullopt};
}

rpc::CellStatus DaemonCell::status() const {
  rpc::CellStatus status{.cell = parts_.config.name,
                         .state = std::string{runner_.name()},
                         .state_text = runner_.reason(),
                         .next = runner_.next(),
                         .waiting = runner_.awaited_device(),
                         .time = control::rfc3339(parts_.wall_clock()),
                         .robot = devices_.robot_status(),
                         .tracker = devices_.tracker_status(),
                         .campaign = campaigns_.status(),
                         .interrupted = campaigns_.interrupted_campaigns(),
                         .model = models_.active_summary(),
                         .stream = stream_.status(),
                         .recording = recording_.status(),
                         .faults = runner_.faults().list()};
  const std::vector<std::string> of_interrupted = campaigns_.also_allowed();
  for (const auto& methods : {runner_.allowed(), of_interrupted})
    for (const std::string& method : methods)
      if (!runner_.rules_out(FaultCode::Store, method)) status.allowed.push_back(method);
  if (std::string not_ready = devices_.how_to_get_ready(); !not_ready.empty())
    status.next = std::move(not_ready);
  else if (!of_interrupted.empty() && std::ranges::count(status.allowed, of_interrupted[0]) > 0)
    status.next = "Resume the interrupted campaign, or abort it.";
  return status;
}

}  // namespace truepose::daemon
