#include "tests/world/cell.hpp"

#include <boost/json/array.hpp>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>

#include "config/cell_config.hpp"
#include "proto/control/access.hpp"
#include "proto/rsi/ethernet_config.hpp"

namespace truepose::world {

namespace fs = std::filesystem;

namespace {

constexpr const char* kToken = "0123456789abcdef0123456789abcdef";
constexpr const char* kSupervisorsToken = "access-0123456789abcdef0123456789abcdef";
constexpr const char* kViewersToken = "access-fedcba9876543210fedcba9876543210";
constexpr int kViewers = 6;
const fs::path kShipped = fs::path{TRUEPOSE_SOURCE_DIR} / "config";

/// Of the users that have a token of their own, in the store's folder.
void write_access_list(const fs::path& store) {
  const fs::path file = store.string() + ".access";
  const control::AccessEntries users{
      {control::entry_for_token("supervisor", control::Role::Operator, kSupervisorsToken),
       control::entry_for_token("viewer", control::Role::Viewer, kViewersToken)}};
  std::ofstream{file} << control::access_text(users);
  fs::permissions(file, fs::perms::owner_read | fs::perms::owner_write);
}

config::CellConfig cell_config() {
  config::CellConfig config = config::load_cell(kShipped / "cell.yaml");
  config.store = "cell.sqlite";
  config.recording.folder = "recordings";
  config.recording.ring_mb = 1;
  config.control.token_file = "token";
  std::ofstream{config.control.token_file} << kToken << '\n';
  fs::permissions(config.control.token_file, fs::perms::owner_read | fs::perms::owner_write);
  write_access_list(config.store);
  return config;
}

rsi::EthernetConfig ethernet_of(const config::Scenario& scenario) {
  std::ifstream file{scenario.ethernet_xml};
  std::ostringstream text;
  text << file.rdbuf();
  return rsi::parse_ethernet_config(text.str()).value();
}

/// Its ports are those of the cell file.
sim::CellOptions options(std::uint64_t seed, const config::CellConfig& config) {
  sim::CellOptions options{.eki_port = config.robot.eki_motion.port,
                           .tracker_port = config.tracker.address.port,
                           .rsi_host = config.stream.listen.host,
                           .rsi_port = config.stream.listen.port,
                           .seed = seed};
  if (config.tracker.protocol == config::TrackerProtocol::Bridge) options.bridge_port = options.tracker_port;
  return options;
}

sim::Machine machine(World& world) {
  const auto executor = world.outside.get_executor();
  return {.io = executor,
          .clock = world.clock,
          .network = world.network.network(),
          .start_rsi = world.rsi.controller(executor)};
}

}  // namespace

Cell::Files Cell::files(const Change& change) {
  Files files{.cell = cell_config(), .scenario = config::load_scenario(kShipped / "scenarios/demo.yaml")};
  files.cell.campaign.candidates = 500;  // a plan is a tenth of a soak's time by 2000
  files.cell.surroundings.obstacles.push_back({{1400, 1400, 0}, {1400, 1400, 1500}, 150});
  files.scenario.programs.push_back(fs::path{TRUEPOSE_SOURCE_DIR} / "tests/world/sps.sub");
  change(files.cell, files.scenario);
  return files;
}

Cell::Cell(std::uint64_t seed, const Change& change)
    : files_{files(change)},
      world{seed},
      disk{world.random.next()},
      max_step_deg{files_.cell.stream.max_step_deg},
      devices{machine(world), scenario, ethernet_of(scenario), options(world.random.next(), files_.cell)},
      pc{world, disk, files_.cell, "run"},
      panel{world, "panel", kToken},
      supervisor{world, "supervisor", kSupervisorsToken},
      mirror{world, "mirror", kViewersToken} {
  const boost::json::array kept{"cell", "campaign", "measurement", "model", "fault", "control"};
  for (int i = 1; i <= kViewers; ++i)
    viewers.emplace_back(world, "viewer " + std::to_string(i), kViewersToken, kept);
}

std::vector<Client*> Cell::clients() {
  std::vector<Client*> all{&panel, &supervisor, &mirror};
  for (Client& viewer : viewers) all.push_back(&viewer);
  return all;
}

boost::asio::awaitable<void> Cell::end_of_daemon() {
  do {
    pc.stop();
    co_await world.pass(std::chrono::milliseconds{100});
  } while (pc.runs());
}

void Cell::change_arm(const std::function<void(config::Scenario&)>& change) {
  change(scenario);
  ++arm_changes;
  devices.exchange_arm(scenario.truth, scenario.robot_serial);
}

}  // namespace truepose::world
