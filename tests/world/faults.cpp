#include "tests/world/faults.hpp"

#include <array>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <string>

#include "tests/world/model_edit.hpp"

namespace truepose::world {

namespace asio = boost::asio;
using namespace std::chrono_literals;
using Kind = config::ScenarioFault::Kind;
using Wait = asio::awaitable<void>;
using std::chrono::milliseconds;

milliseconds lasting(Random& random, milliseconds shortest, milliseconds longest) {
  const double ratio = static_cast<double>(longest.count()) / static_cast<double>(shortest.count());
  return milliseconds{
      static_cast<std::int64_t>(static_cast<double>(shortest.count()) * std::pow(ratio, random.uniform()))};
}

namespace {

// ---- The PC ----

Wait kill_daemon(Cell& cell, Random&) {
  cell.pc.kill();
  co_return;
}

Wait stop_daemon(Cell& cell, Random&) {
  cell.pc.stop();
  co_return;
}

Wait lose_power(Cell& cell, Random& random) {
  cell.pc.lose_power();
  cell.pc.has_power = false;
  co_await cell.world.pass(lasting(random, 30s, 10min));
  cell.pc.has_power = true;
}

Wait spoil_disk(Cell& cell, test::FailingDisk::Fault fault, milliseconds time) {
  cell.disk.fail_after(0, fault);
  co_await cell.world.pass(time);
  cell.disk.repair();
}

Wait fill_disk(Cell& cell, Random& random) {
  return spoil_disk(cell, test::FailingDisk::Fault::Full, lasting(random, 10s, 20min));
}

Wait break_disk(Cell& cell, Random& random) {
  return spoil_disk(cell, test::FailingDisk::Fault::Broken, lasting(random, 1s, 2min));
}

Wait lock_disk(Cell& cell, Random& random) {
  return spoil_disk(cell, test::FailingDisk::Fault::ReadOnly, lasting(random, 10s, 20min));
}

Wait slow_disk(Cell& cell, Random& random) {
  cell.pc.slowness = random.uniform(2, 100);
  co_await cell.world.pass(lasting(random, 10s, 20min));
  cell.pc.slowness = 1;
}

/// As firmware does, or a machine that is moved to another host.
Wait stall(Cell& cell, Random& random) {
  const milliseconds time = lasting(random, 20ms, 20s);
  cell.pc.stall(cell.world.clock.now() + time);
  cell.world.rsi.cut = true;
  co_await cell.world.pass(time);
  cell.world.rsi.cut = false;
}

/// A link is set to another length, and to the right one later. Each takes effect with a restart.
Wait edit_robot_file(Cell& cell, Random& random) {
  const double by_mm = random.uniform(2, 20);
  const auto lengthen_and_restart = [&cell](double mm) {
    cell.pc.edit([mm](config::CellConfig& config) { config.robot.model.joints.at(1).a_mm += mm; });
    cell.pc.stop();
  };
  lengthen_and_restart(by_mm);
  co_await cell.world.pass(lasting(random, 10min, 2h));
  lengthen_and_restart(-by_mm);
}

Wait set_clock(Cell& cell, Random& random) {
  cell.pc.wall_clock_error += std::chrono::seconds{static_cast<std::int64_t>(random.uniform(-3600, 3600))};
  co_return;
}

// ---- The network ----

constexpr std::uint16_t kEki = 54600, kEkiState = 54601, kTracker = 7000, kControl = 7210;

Wait reset_connections(Cell& cell, Random& random) {
  const bool of_tracker = random.uniform() < 0.5;
  cell.world.network.reset(of_tracker ? drivers::MemoryNetwork::Ports{kTracker}
                                      : drivers::MemoryNetwork::Ports{kEki, kEkiState});
  co_return;
}

using Ports = drivers::MemoryNetwork::Ports;

/// What the network does to devices, for some time.
Wait disturb(Cell& cell, Random& random, void (drivers::MemoryNetwork::*set)(const Ports&, bool), bool to,
             const Ports ports) {
  (cell.world.network.*set)(ports, to);
  co_await cell.world.pass(lasting(random, 1s, 4min));
  (cell.world.network.*set)(ports, !to);
}

template <std::uint16_t... kPorts>
Wait silence(Cell& cell, Random& random) {
  return disturb(cell, random, &drivers::MemoryNetwork::silence, true, {kPorts...});
}
/// The plug is pulled: no end of a connection learns of it.
template <std::uint16_t... kPorts>
Wait unplug(Cell& cell, Random& random) {
  return disturb(cell, random, &drivers::MemoryNetwork::power, false, {kPorts...});
}

Wait slow_network(Cell& cell, Random& random) {
  cell.world.network.latency = lasting(random, 10ms, 5s);
  co_await cell.world.pass(lasting(random, 1s, 2min));
  cell.world.network.latency = {};
}

/// What scans ports, speaks another protocol, or means to do harm.
Wait disturb_control_port(Cell& cell, Random& random) {
  const auto stream = cell.world.network.streams()(cell.world.outside.get_executor());
  const auto failed = co_await stream->connect("127.0.0.1", kControl);
  if (failed) co_return;
  std::string bytes(static_cast<std::size_t>(random.uniform(0, 100'000)), '\0');
  for (char& byte : bytes) byte = static_cast<char>(random.next());
  constexpr std::array kBegins{"", "GET / HTTP/1.1\r\n\r\n", "{\"jsonrpc\":\"2.0\",\"id\":1,\"method\":\"",
                               "\x16\x03\x01", "[[[["};
  bytes.insert(0, kBegins.at(static_cast<std::size_t>(random.uniform() * kBegins.size())));
  co_await stream->write(bytes);
  co_await cell.world.pass(lasting(random, 10ms, 2min));
}

Wait cut_clients(Cell& cell, Random&) {
  cell.world.network.reset({kControl});
  co_return;
}

Wait cut_rsi(Cell& cell, Random& random) {
  cell.world.rsi.cut = true;
  co_await cell.world.pass(lasting(random, 8ms, 5s));
  cell.world.rsi.cut = false;
}

Wait slow_rsi(Cell& cell, Random& random) {
  const auto before = cell.world.rsi.way;
  cell.world.rsi.way = lasting(random, 1ms, 30ms);
  co_await cell.world.pass(lasting(random, 100ms, 30s));
  cell.world.rsi.way = before;
}

// ---- Controller, tracker and the people at them ----

/// A fault of the simulator's, for some time.
Wait misbehave(Cell& cell, config::ScenarioFault fault, milliseconds time) {
  fault.lasts = time.count();
  cell.devices.begin(fault);
  co_await cell.world.pass(time);
}

template <Kind kKind, std::int64_t kShortest_ms, std::int64_t kLongest_ms>
Wait of_kind(Cell& cell, Random& random) {
  config::ScenarioFault fault;
  fault.kind = kKind;
  fault.ipoc_by = static_cast<std::int64_t>(random.uniform(-1000, 1000));
  fault.percent = static_cast<int>(random.uniform(1, 100));
  fault.mode = config::ScenarioFault::Mode::T1;
  return misbehave(cell, fault, lasting(random, milliseconds{kShortest_ms}, milliseconds{kLongest_ms}));
}

/// A vector of at most this length.
Eigen::Vector3d shift(Random& random, double longest_mm) {
  return {random.uniform(-longest_mm, longest_mm), random.uniform(-longest_mm, longest_mm),
          random.uniform(-longest_mm, longest_mm)};
}

/// For good.
Wait bump_tracker(Cell& cell, Random& random) {
  config::ScenarioFault fault;
  fault.kind = Kind::TrackerBump;
  fault.by_mm = shift(random, 3);
  cell.tracker_moved_mm += fault.by_mm;
  cell.devices.begin(fault);
  co_return;
}

/// The daemon is killed, and before it is back the tripod stands elsewhere.
Wait move_tripod(Cell& cell, Random& random) {
  cell.pc.kill();
  return bump_tracker(cell, random);
}

constexpr std::chrono::minutes kExchange{10};

/// Another arm of the same type, with its controller off meanwhile.
Wait exchange_arm(Cell& cell, Random& random) {
  config::ScenarioFault off;
  off.kind = Kind::ControllerRestart;
  off.lasts = milliseconds{kExchange}.count();
  cell.devices.begin(off);
  cell.change_arm([&random](config::Scenario& scenario) {
    ++scenario.robot_serial;
    scenario.truth = scenario.nominal;
    for (Joint& joint : scenario.truth.joints) {
      joint.a_mm += random.uniform(-0.5, 0.5);
      joint.d_mm += random.uniform(-0.5, 0.5);
      joint.theta_rad += random.uniform(-0.003, 0.003);
      joint.alpha_rad += random.uniform(-0.003, 0.003);
    }
  });
  co_await cell.world.pass(kExchange);
}

template <Kind kKind, int kBy_mm>
Wait shift_points(Cell& cell, Random& random) {
  config::ScenarioFault fault;
  fault.kind = kKind;
  fault.by_mm = shift(random, kBy_mm);
  return misbehave(cell, fault, lasting(random, 1s, 10min));
}

Wait scatter_tracker(Cell& cell, Random& random) {
  config::ScenarioFault fault;
  fault.kind = Kind::TrackerNoise;
  fault.sigma_mm = random.uniform(0.02, 0.5);
  return misbehave(cell, fault, lasting(random, 1s, 10min));
}

constexpr std::array kFaults{
    FaultKind{"daemon-killed", 2, Waits::ForNothing, &kill_daemon},
    FaultKind{"daemon-killed-in-a-program", 2, Waits::ForRsi, &kill_daemon},
    FaultKind{"tripod-moved-in-an-interruption", 2, Waits::ForCampaign, &move_tripod},
    FaultKind{"daemon-stopped", 1, Waits::ForNothing, &stop_daemon},
    FaultKind{"power-lost", 1, Waits::ForNothing, &lose_power},
    FaultKind{"disk-full", 0.5, Waits::ForNothing, &fill_disk},
    FaultKind{"disk-broken", 0.5, Waits::ForNothing, &break_disk},
    FaultKind{"disk-read-only", 0.5, Waits::ForNothing, &lock_disk},
    FaultKind{"disk-slow", 1, Waits::ForNothing, &slow_disk},
    FaultKind{"pc-stalled", 2, Waits::ForNothing, &stall},
    FaultKind{"pc-stalled-in-a-program", 2, Waits::ForRsi, &stall},
    FaultKind{"robot-file-edited", 0.1, Waits::ForNothing, &edit_robot_file},
    FaultKind{"model-edited", 0.2, Waits::ForNothing, &edit_model},
    FaultKind{"clock-set", 0.5, Waits::ForNothing, &set_clock},
    FaultKind{"connections-reset", 2, Waits::ForNothing, &reset_connections},
    FaultKind{"controller-silent", 2, Waits::ForNothing, &silence<kEki, kEkiState>},
    FaultKind{"tracker-link-silent", 2, Waits::ForNothing, &silence<kTracker>},
    FaultKind{"controller-unplugged", 1, Waits::ForNothing, &unplug<kEki, kEkiState>},
    FaultKind{"tracker-unplugged", 1, Waits::ForNothing, &unplug<kTracker>},
    FaultKind{"network-slow", 2, Waits::ForNothing, &slow_network},
    FaultKind{"foreign-client", 2, Waits::ForNothing, &disturb_control_port},
    FaultKind{"clients-cut", 2, Waits::ForNothing, &cut_clients},
    FaultKind{"rsi-cut", 12, Waits::ForRsi, &cut_rsi},
    FaultKind{"rsi-slow", 6, Waits::ForRsi, &slow_rsi},
    FaultKind{"beam-broken", 12, Waits::ForNothing, &of_kind<Kind::BeamBreak, 500, 60'000>},
    FaultKind{"tracker-restarted", 1, Waits::ForNothing, &of_kind<Kind::TrackerRestart, 1, 2>},
    FaultKind{"tracker-busy", 2, Waits::ForNothing, &of_kind<Kind::TrackerBusy, 1'000, 60'000>},
    FaultKind{"tracker-silent", 2, Waits::ForNothing, &of_kind<Kind::TrackerSilent, 1'000, 300'000>},
    FaultKind{"tracker-storm", 1, Waits::ForNothing, &of_kind<Kind::TrackerStorm, 1'000, 10'000>},
    FaultKind{"tracker-bumped", 2, Waits::ForNothing, &bump_tracker},
    FaultKind{"tracker-biased", 6, Waits::ForNothing, &shift_points<Kind::TrackerBias, 1>},
    FaultKind{"tracker-scattering", 6, Waits::ForNothing, &scatter_tracker},
    FaultKind{"other-reflector", 6, Waits::ForNothing, &shift_points<Kind::TrackerStray, 200>},
    FaultKind{"eki-dropped", 2, Waits::ForNothing, &of_kind<Kind::EkiDrop, 100, 60'000>},
    FaultKind{"program-stopped", 3, Waits::ForNothing, &of_kind<Kind::ProgramStop, 1'000, 120'000>},
    FaultKind{"program-reset", 1, Waits::ForNothing, &of_kind<Kind::ProgramReset, 1, 2>},
    FaultKind{"emergency-stop", 2, Waits::ForNothing, &of_kind<Kind::EmergencyStop, 1'000, 300'000>},
    FaultKind{"gate-opened", 2, Waits::ForNothing, &of_kind<Kind::GateOpen, 1'000, 300'000>},
    FaultKind{"key-turned", 1, Waits::ForNothing, &of_kind<Kind::OperatingMode, 1'000, 120'000>},
    FaultKind{"override-set", 2, Waits::ForNothing, &of_kind<Kind::Override, 1'000, 120'000>},
    FaultKind{"controller-restarted", 0.5, Waits::ForNothing,
              &of_kind<Kind::ControllerRestart, 30'000, 180'000>},
    FaultKind{"arm-exchanged", 0.1, Waits::ForNothing, &exchange_arm},
    FaultKind{"rsi-dropped", 8, Waits::ForRsi, &of_kind<Kind::RsiDrop, 8, 2'000>},
    FaultKind{"rsi-datagrams-lost", 8, Waits::ForRsi, &of_kind<Kind::RsiLoseDatagrams, 8, 2'000>},
    FaultKind{"rsi-replies-lost", 12, Waits::ForRsi, &of_kind<Kind::RsiLoseReplies, 8, 2'000>},
    FaultKind{"rsi-duplicated", 4, Waits::ForRsi, &of_kind<Kind::RsiDuplicate, 8, 10'000>},
    FaultKind{"rsi-late", 4, Waits::ForRsi, &of_kind<Kind::RsiLate, 8, 10'000>},
    FaultKind{"rsi-corrupted", 4, Waits::ForRsi, &of_kind<Kind::RsiCorrupt, 8, 10'000>},
    FaultKind{"rsi-reordered", 4, Waits::ForRsi, &of_kind<Kind::RsiReorder, 8, 10'000>},
    FaultKind{"rsi-silent", 4, Waits::ForRsi, &of_kind<Kind::RsiSilence, 8, 2'000>},
    FaultKind{"rsi-restarted", 2, Waits::ForRsi, &of_kind<Kind::RsiRestart, 40, 2'000>},
    FaultKind{"rsi-ignored", 6, Waits::ForRsi, &of_kind<Kind::RsiIgnore, 1'000, 60'000>},
    FaultKind{"rsi-second-sender", 6, Waits::ForRsi, &of_kind<Kind::RsiSecondSender, 1'000, 30'000>},
};

}  // namespace

std::span<const FaultKind> fault_kinds() { return kFaults; }

}  // namespace truepose::world
