#include "tools/truepose/doctor/probes.hpp"

#include <future>

#include "config/ethernet_file.hpp"
#include "config/text_file.hpp"
#include "daemon/realtime/stream_options.hpp"
#include "tools/truepose/online/rpc_client.hpp"

namespace truepose::tools {

namespace {

namespace fs = std::filesystem;

constexpr std::chrono::seconds kAnswer{3};

/// Where the cell's daemon listens.
std::string daemon_of(const config::CellConfig& cell) {
  const fs::path socket = cell.runtime / "control.sock";
  std::error_code none;
  const bool tcp = cell.control.listen.port != 0;
  if (!cell.runtime.empty() && (!tcp || fs::is_socket(socket, none))) return fs::absolute(socket);
  return config::text(cell.control.listen);
}

std::optional<rsi::EthernetConfig> ethernet_of(const config::StreamConfig& stream) try {
  return config::load_ethernet(stream.ethernet_xml);
} catch (const config::ConfigError&) {
  return std::nullopt;  // the cell file's check says why
}

/// A device that the daemon talks to is left to it, and the controller of an armed stream to its own program.
bool may_be_asked(const rpc::CellStatus& status, bool is_connected) {
  return !is_connected && !status.stream.armed;
}

}  // namespace

DaemonObservation observe_daemon(const std::string& cell, const DaemonAddress& address) {
  auto client = RpcClient::connect(address);
  if (!client) return {.unreachable = client.error().message};
  const auto info = client->call(rpc::SystemInfo{}, kAnswer);
  if (!info) return {.unreachable = info.error().message};
  const rpc::SystemInfo::Result& its = info->record;
  if (its.cell != cell)
    return {.unreachable =
                "the daemon at " + address.daemon + " is that of cell " + its.cell + ", not of " + cell};
  auto status = client->call(rpc::GetCellStatus{}, kAnswer);
  if (status) return {.version = its.version, .status = std::move(status->record)};
  // Of another version, that is to be said before what of its answer cannot be read.
  if (its.version != TRUEPOSE_VERSION) return {.version = its.version};
  return {.unreachable = status.error().message};
}

Observations observe(const config::CellConfig& cell, DaemonAddress address) {
  if (address.daemon.empty()) address.daemon = daemon_of(cell);
  if (address.token_file.empty()) address.token_file = cell.control.token_file;
  Observations seen{.check = daemon::check(cell),
                    .ethernet = ethernet_of(cell.stream),
                    .interfaces = observe_interfaces(),
                    .daemon = observe_daemon(cell.name, address)};
  const bool runs = seen.daemon.unreachable.empty();
  const rpc::CellStatus& status = seen.daemon.status;
  const auto aside = [](auto probe) { return std::async(std::launch::async, probe); };
  auto rsi = aside([&] { return observe_rsi(cell.stream, runs); });
  std::future<decltype(daemon::observe_robot(cell.robot))> robot;
  std::future<decltype(daemon::observe_tracker(cell.tracker))> tracker;
  const bool is_driven = !daemon::why_unfit(cell.robot.model);  // the check says it where not
  if (is_driven && may_be_asked(status, status.robot.connected))
    robot = aside([&] { return daemon::observe_robot(cell.robot); });
  if (may_be_asked(status, status.tracker.connected))
    tracker = aside([&] { return daemon::observe_tracker(cell.tracker); });
  seen.machine = observe_machine(cell);
  if (robot.valid()) seen.robot = robot.get();
  if (tracker.valid()) seen.tracker = tracker.get();
  seen.rsi = rsi.get();
  return seen;
}

}  // namespace truepose::tools
