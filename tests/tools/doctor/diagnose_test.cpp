// Every finding of the doctor, each provoked by what the probes would have seen.
#include "tools/truepose/doctor/diagnose.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <boost/json/object.hpp>
#include <functional>
#include <ostream>

#include "core/arm/forward.hpp"
#include "core/math/units.hpp"
#include "proto/record/json_io.hpp"

namespace truepose::tools {

void PrintTo(const Finding& finding, std::ostream* out) {
  *out << finding.area << ' ' << static_cast<int>(finding.level) << ": " << finding.message.code << ' '
       << sentences(finding.message);
}

namespace {

namespace json = boost::json;
using namespace std::chrono_literals;
using testing::AllOf;
using testing::Contains;
using testing::Field;
using testing::HasSubstr;

constexpr std::uint32_t kPc = 0xc0a82c0a, kController = 0xc0a82c01;  // 192.168.44.10 and .1
constexpr drivers::UdpSource kSource{kController, 52000};

/// The shipped cell, in a network.
config::CellConfig cell_in_a_plant() {
  config::CellConfig cell = config::load_cell(TRUEPOSE_SOURCE_DIR "/config/cell.yaml");
  cell.robot.rsi_peer = "192.168.44.1";
  cell.stream.listen = {"192.168.44.10", 49152};
  return cell;
}

const rsi::Axes kAxes{0.1, -1.5, 1.5, 0.2, 0.4, -0.3};

rsi::CartesianPose flange_at(const config::CellConfig& cell, const rsi::Axes& axes) {
  const JointVector q = Eigen::Map<const JointVector>(axes.data(), 6);
  const Eigen::Vector3d p = forward_kinematics(cell.robot.model, q).translation();
  return {.x_mm = p.x(), .y_mm = p.y(), .z_mm = p.z()};
}

RsiSender good_sender(const config::CellConfig& cell) {
  RsiSender sender{.source = kSource, .frames = 251, .last = drivers::TimePoint{} + 1s};
  sender.ipoc_begin = 1000;
  sender.ipoc = 2000;
  sender.ipoc_step = 4;
  sender.delay_begin = 0;
  sender.frame.delay = 0;
  sender.frame.aipos_rad = kAxes;
  sender.frame.rist = flange_at(cell, kAxes);
  sender.elements = {{"RIst.X", "AIPos.A1", "IPOC"}, 4};
  return sender;
}

daemon::RobotObservation good_robot(const config::CellConfig& cell) {
  const JointVector q = Eigen::Map<const JointVector>(kAxes.data(), 6);
  return {{"#KR210R2700_2 C4 FLR", "4711", "KSS 8.6"},
          {.q = q, .X_BF_reported = forward_kinematics(cell.robot.model, q), .ready = true}};
}

rsi::EthernetConfig small_ethernet() {
  rsi::EthernetConfig ethernet;
  ethernet.send = {{.tag = "DEF_RIst"}, {.tag = "DEF_AIPos"}};
  return ethernet;
}

/// Of a cell in which all is well, before the daemon is started.
Observations all_is_well(const config::CellConfig& cell) {
  return {.check = {{daemon::CheckFinding::Level::Good, "good"}},
          .ethernet = small_ethernet(),
          .interfaces = {{"lo", 0x7f000001, 0xff000000}, {"eth1", kPc, 0xffffff00}},
          .daemon = {.unreachable = "the daemon does not answer"},
          .rsi = {.senders = {good_sender(cell)}, .seen = std::vector<SeenStream>{}, .firewall = ""},
          .robot = good_robot(cell),
          .tracker = drivers::TrackerIdentity{"AT901", "1", "3.8"},
          .machine = {.clocksource = "tsc", .store_free_bytes = 100'000'000'000}};
}

/// A daemon that runs, with this status.
DaemonObservation daemon_with(const rpc::StreamStatus& stream) {
  return {.version = TRUEPOSE_VERSION,
          .status = {.state = "streaming",
                     .robot = {.connected = true, .model = "KR210", .serial = "1"},
                     .tracker = {.connected = true, .model = "AT901", .serial = "2"},
                     .stream = stream}};
}

rpc::StreamStatus stream_with(const json::object& more) {
  json::object stream =
      record::to_json(rpc::StreamStatus{.state = "correcting", .packet_age_ms = 2, .answered = 1000});
  for (const auto& [key, value] : more) stream[key] = value;
  return record::from_json<rpc::StreamStatus>(stream).value();
}

struct Case {
  const char* name;
  std::function<void(config::CellConfig& cell, Observations& seen)> provoke;
  const char* area;
  Level level;
  const char *code, *finding, *next;
};

void PrintTo(const Case& one, std::ostream* out) { *out << one.name; }

void silence(Observations& seen) { seen.rsi.senders.clear(); }

void let_run(Observations& seen, const json::object& stream) {
  seen.daemon = daemon_with(stream_with(stream));
  seen.robot.reset();
  seen.tracker.reset();
  silence(seen);
}

/// Of a stream, 15000 replies of which so many were late by that.
json::object last_minute(const char* by, int late) {
  json::object counts{{"answered", 15000}, {"late", 0}, {"daemon", 0}, {"machine", 0}, {"network", 0}};
  counts[by] = late;
  return {{"late", 480}, {"last_minute", counts}};
}

RsiSender& sender(Observations& seen) { return seen.rsi.senders.at(0); }

/// Every packet of 1.2 s arrived.
void set_cycle(Observations& seen, int period_ms, std::uint64_t ipoc_step) {
  constexpr int kTime_ms = 1200;
  RsiSender& its = sender(seen);
  its.frames = static_cast<std::uint64_t>(kTime_ms / period_ms) + 1;
  its.last = its.first + std::chrono::milliseconds{kTime_ms};
  its.shortest = std::chrono::milliseconds{period_ms};
  its.ipoc_step = ipoc_step;
  its.ipoc = its.ipoc_begin + (its.frames - 1) * ipoc_step;
}

// clang-format off
const std::vector<Case> kCases{
    // ---- cell file ----
    {"CheckWarns", [](auto&, auto& seen) { seen.check = {{daemon::CheckFinding::Level::Warning, "HOLDON is 0"}}; },
     "cell file", Level::Warning, "D_CELL_FILE", "HOLDON is 0", "trueposed --config cell.yaml --check"},
    {"CheckFails", [](auto&, auto& seen) { seen.check = {{daemon::CheckFinding::Level::Failure, "no token"}}; },
     "cell file", Level::Fault, "D_CELL_FILE", "no token", "--check"},
    // ---- daemon ----
    {"DaemonDown", [](auto&, auto&) {}, "daemon", Level::Fault, "D_DAEMON", "the daemon does not answer", "systemctl start"},
    {"DaemonOfAnotherVersion", [](auto&, auto& seen) { seen.daemon = {.version = "0.0.1"}; },
     "daemon", Level::Warning, "D_VERSION", "in version 0.0.1", "restart"},
    {"DaemonFault", [](auto&, auto& seen) {
       let_run(seen, {});
       seen.daemon.status.faults = {{"E_MODEL", "error", "the model is not the one: activate another"}};
     }, "daemon", Level::Fault, "E_MODEL", "the model is not the one", "activate another"},
    {"TrackerFaultOfTheDaemon", [](auto&, auto& seen) {
       let_run(seen, {});
       seen.daemon.status.faults = {{"E_TRACKER", "warning", "it is cold: wait"}};
     }, "tracker", Level::Warning, "E_TRACKER", "it is cold", "wait"},
    // ---- RSI, by what comes ----
    {"PortTaken", [](auto&, auto& seen) {
       seen.rsi.not_bound = "RSI address is in use by nc (process 7)";
       seen.rsi.taken = true;
     }, "rsi", Level::Fault, "D_PORT_TAKEN", "in use by nc (process 7)", "end that process"},
    {"AddressNotHere", [](auto&, auto& seen) { seen.rsi.not_bound = "is not one of this machine's"; },
     "rsi", Level::Fault, "D_LISTEN", "not one of this machine's", "an address of this PC (lo 127.0.0.1, eth1 192.168.44.10)"},
    {"OtherController", [](auto& cell, auto&) { cell.robot.rsi_peer = "192.168.44.2"; },
     "rsi", Level::Fault, "D_SENDER", "packets of 192.168.44.1:52000 are dropped: the controller is expected at 192.168.44.2", "robot.rsi_peer"},
    {"AllMalformed", [](auto&, auto& seen) {
       sender(seen).frames = 0;
       sender(seen).malformed = 9;
       sender(seen).why_malformed = "IPOC is missing: <Rob>";
     }, "rsi", Level::Fault, "D_MALFORMED", "packets of 192.168.44.1:52000 cannot be understood (9 so far): IPOC is missing", "load "},
    {"SomeMalformed", [](auto&, auto& seen) { sender(seen).malformed = 1; },
     "rsi", Level::Warning, "D_MALFORMED", "cannot be understood (1 so far)", "load "},
    {"ElementMissing", [](auto&, auto& seen) { sender(seen).elements.names = {"RIst.X", "AIPoz.A1"}; },
     "rsi", Level::Fault, "D_ELEMENTS", "not in it: AIPoz; not sent: DEF_AIPos", "truepose_rsi_ethernet.xml on the controller"},
    {"ElementTooMany", [](auto&, auto& seen) { sender(seen).elements.names.push_back("MACur.A1"); },
     "rsi", Level::Warning, "D_ELEMENTS", "not in it: MACur", "load "},
    {"Precision", [](auto&, auto& seen) { sender(seen).elements.decimals = 1; },
     "rsi", Level::Warning, "L_PRECISION", "192.168.44.1:52000: Precision 1 rounds the axes to 0.1 deg", "set Precision"},
    {"CycleOf12Ms", [](auto&, auto& seen) { set_cycle(seen, 12, 12); },
     "rsi", Level::Fault, "D_CYCLE", "192.168.44.1:52000 sends packets every 12.00 ms, its IPOC rises by 12, and stream.cycle_ms is 4",
     "set stream.cycle_ms to 12 and restart trueposed, or start RSI with #IPO_FAST"},
    {"CycleOf40Ms", [](auto&, auto& seen) { set_cycle(seen, 40, 40); },
     "rsi", Level::Fault, "D_CYCLE", "sends packets every 40.00 ms, its IPOC rises by 40, and stream.cycle_ms is 4",
     "set stream.cycle_ms to 40"},
    {"CycleOf12MsOfAKrC2", [](auto&, auto& seen) { set_cycle(seen, 12, 1); },
     "rsi", Level::Fault, "D_CYCLE", "every 12.00 ms, its IPOC rises by 1, and stream.cycle_ms is 4", "set stream.cycle_ms to 12"},
    {"SlowSender", [](auto&, auto& seen) { set_cycle(seen, 40, 4); },
     "rsi", Level::Fault, "D_CYCLE_OF_SENDER", "every 40.00 ms, its IPOC rises by 4, and stream.cycle_ms is 4",
     "make the sender send every 4 ms, as its IPOC counts, or correct its IPOC and stream.cycle_ms"},
    {"WrongIpoc", [](auto&, auto& seen) { set_cycle(seen, 4, 12); },
     "rsi", Level::Fault, "D_CYCLE_AND_IPOC", "every 4.00 ms, its IPOC rises by 12, and stream.cycle_ms is 4",
     "make the sender send every 12 ms, as its IPOC counts, and set stream.cycle_ms to 12"},
    {"WrongArm", [](auto&, auto& seen) { sender(seen).frame.rist->x_mm += 100; },
     "rsi", Level::Fault, "D_STREAM", "RIst is 100.0 mm", "correct robot.file"},
    {"BeyondLimits", [](auto& cell, auto& seen) {
       (*sender(seen).frame.aipos_rad)[0] = 200 / kDegPerRad;
       sender(seen).frame.rist = flange_at(cell, *sender(seen).frame.aipos_rad);
     }, "rsi", Level::Warning, "D_AXIS_LIMIT", "A1 is at 200.0 deg, outside the robot file's -185.0 to 185.0", "robot.file"},
    {"Losses", [](auto&, auto& seen) { sender(seen).frames = 200; },
     "rsi", Level::Warning, "D_LOSSES", "20.3 % of the packets of 192.168.44.1:52000", "cable"},
    // ---- RSI, where nothing comes ----
    {"Silence", [](auto&, auto& seen) {
       silence(seen);
       seen.robot = std::unexpected(drivers::RobotError{drivers::RobotFault::Unreachable, "refused"});
     }, "rsi", Level::Fault, "D_NO_PACKET", "no RSI packet comes to 192.168.44.10:49152 (0 so far)", "RSI_ON"},
    {"SilenceOfAControllerThatAnswers", [](auto&, auto& seen) { silence(seen); },
     "rsi", Level::Warning, "D_NO_PACKET", "no RSI packet comes", "RSI_ON"},
    {"SomethingForNobody", [](auto&, auto& seen) {
       silence(seen);
       seen.rsi.seen.reset();
       seen.rsi.unclaimed = 375;
     }, "rsi", Level::Warning, "D_NO_PACKET", "375 UDP packets came to ports without a program: as root", "RSI_ON"},
    {"OtherPort", [](auto&, auto& seen) {
       silence(seen);
       seen.rsi.seen = {{kSource, {kPc, 49153}, 375}};
     }, "rsi", Level::Fault, "D_TARGET", "192.168.44.1:52000 sends RSI packets to 192.168.44.10:49153, but", "IP_NUMBER and PORT"},
    {"OtherPortFromElsewhere", [](auto&, auto& seen) {
       silence(seen);
       seen.rsi.seen = {{{0x0a000009, 5}, {kPc, 49153}, 375}};
     }, "rsi", Level::Warning, "D_TARGET", "10.0.0.9:5 sends RSI packets to 192.168.44.10:49153, but", "IP_NUMBER and PORT"},
    {"OtherAddress", [](auto&, auto& seen) {
       silence(seen);
       seen.rsi.seen = {{kSource, {0x0a000005, 49152}, 375}};
     }, "rsi", Level::Fault, "D_TARGET", "sends RSI packets to 10.0.0.5:49152, but stream.listen is 192.168.44.10:49152", "IP_NUMBER"},
    {"DroppedByWhatIsNotKnown", [](auto&, auto& seen) {
       silence(seen);
       seen.rsi.seen = {{kSource, {kPc, 49152}, 375}};
     }, "rsi", Level::Fault, "D_DROPPED", "they do not come through; no rule of a firewall was found", "rp_filter"},
    {"FirewallBeforeTheDaemon", [](auto&, auto& seen) {
       let_run(seen, {{"packet_age_ms", nullptr}});
       seen.rsi.seen = {{kSource, {kPc, 49152}, 375}};
       seen.rsi.firewall = "table inet filter {\n chain input {\n  type filter hook input priority 0; policy drop;\n }\n}\n";
     }, "rsi", Level::Fault, "D_FIREWALL", "policy drop", "let UDP port 49152 in"},
    {"SilenceAfterSome", [](auto&, auto& seen) { let_run(seen, {{"packet_age_ms", nullptr}, {"cycles", 12}}); },
     "rsi", Level::Warning, "D_NO_PACKET", "no RSI packet comes to 192.168.44.10:49152 (12 so far)", "RSI_ON"},
    {"FirewallRule", [](auto&, auto& seen) {
       silence(seen);
       seen.rsi.firewall = "table inet filter {\n chain input {\n  type filter hook input priority 0; policy drop;\n }\n}\n";
     }, "rsi", Level::Warning, "D_FIREWALL", "policy drop", "let UDP port 49152 in"},
    {"CardOff", [](auto&, auto& seen) { silence(seen); seen.interfaces[1].up = false; },
     "rsi", Level::Fault, "D_CARD_OFF", "eth1, which has 192.168.44.10, is switched off", "ip link set eth1 up"},
    {"CableOut", [](auto&, auto& seen) { silence(seen); seen.interfaces[1].running = false; },
     "rsi", Level::Fault, "D_NO_LINK", "eth1, which has 192.168.44.10, has no link", "plug in"},
    {"OtherNetwork", [](auto& cell, auto& seen) { silence(seen); cell.robot.rsi_peer = "192.168.45.1"; },
     "rsi", Level::Fault, "D_NETWORK", "192.168.45.1 is not in the network of eth1, 192.168.44.0/24", "one RSI network"},
    // ---- RSI, by what the daemon tells ----
    {"StreamFault", [](auto&, auto& seen) {
       const char* reason = "the controller does not take replies: it has another SENTYPE: load that one there";
       let_run(seen, {{"state", "fault"}, {"reason", reason}});
       seen.daemon.status.faults = {{"E_CELL", "error", reason}};
     }, "rsi", Level::Fault, "D_STREAM", "it has another SENTYPE", "load that one there"},
    {"StreamHolds", [](auto&, auto& seen) {
       let_run(seen, {{"state", "holding"}, {"reason", "the robot program is stopped: the correction is held"}});
     }, "rsi", Level::Warning, "D_STREAM", "the robot program is stopped", "held"},
    {"ForeignPackets", [](auto&, auto& seen) {
       let_run(seen, {{"refused", "packets of 10.0.0.9:5 are dropped: expected elsewhere; give it as robot.rsi_peer"}, {"unexpected_sender", 7}});
     }, "rsi", Level::Fault, "D_SENDER", "10.0.0.9:5 are dropped: expected elsewhere", "robot.rsi_peer"},
    {"MalformedPackets", [](auto&, auto& seen) {
       let_run(seen, {{"refused", "a packet was not understood: IPOC is missing"}, {"malformed", 7}});
     }, "rsi", Level::Fault, "D_MALFORMED", "IPOC is missing", "truepose_rsi_ethernet.xml on the controller"},
    {"LateByTruepose", [](auto&, auto& seen) { let_run(seen, last_minute("daemon", 480)); },
     "rsi", Level::Warning, "D_LATE_BY_DAEMON", "replies late by truepose's own fault: 3.2 % of the last minute's 15000", "log"},
    {"LateByTheMachine", [](auto&, auto& seen) { let_run(seen, last_minute("machine", 15)); },
     "rsi", Level::Warning, "D_LATE_BY_MACHINE", "replies late because this PC did not run truepose in time: 0.1 % of", "processor"},
    {"LateByTheNetwork", [](auto&, auto& seen) { let_run(seen, last_minute("network", 480)); },
     "rsi", Level::Warning, "D_LATE_BY_NETWORK", "replies late because of the network or the controller: 3.2 % of", "cable"},
    {"Late", [](auto&, auto& seen) { let_run(seen, last_minute("late", 480)); },
     "rsi", Level::Warning, "D_LATE", "replies that were not with the controller in time (Delay): 3.2 % of", "machine"},
    {"Answered", [](auto&, auto& seen) { let_run(seen, {}); }, "rsi", Level::Ok, "D_OK", "are answered: 1000", ""},
    // ---- robot ----
    {"RobotRefused", [](auto&, auto& seen) {
       silence(seen);
       seen.robot = std::unexpected(drivers::RobotError{drivers::RobotFault::Unreachable, "CellLink: refused"});
     }, "robot", Level::Fault, "D_ROBOT", "CellLink: refused", "start truepose_motion"},
    {"RobotRefusedBesideAnotherProgram", [](auto&, auto& seen) {
       seen.robot = std::unexpected(drivers::RobotError{drivers::RobotFault::Unreachable, "CellLink: refused"});
     }, "robot", Level::Warning, "D_ROBOT", "CellLink: refused", "start truepose_motion"},
    {"RobotSilent", [](auto&, auto& seen) {
       silence(seen);
       seen.robot = std::unexpected(drivers::RobotError{drivers::RobotFault::Timeout, "connected but silent"});
     }, "robot", Level::Fault, "D_ROBOT", "connected but silent", "sps.sub"},
    {"RobotSpeaksOtherwise", [](auto&, auto& seen) {
       silence(seen);
       seen.robot = std::unexpected(drivers::RobotError{drivers::RobotFault::Protocol, "version 9"});
     }, "robot", Level::Fault, "D_ROBOT", "version 9", "truepose kuka write"},
    {"RobotRejects", [](auto&, auto& seen) {
       silence(seen);
       seen.robot = std::unexpected(drivers::RobotError{drivers::RobotFault::Refused, "rejected"});
     }, "robot", Level::Fault, "D_ROBOT", "rejected", "pendant"},
    {"RobotIsAnother", [](auto& cell, auto&) { cell.robot.expect_model = "KR16"; },
     "robot", Level::Fault, "D_WRONG_ARM", "the cell expects KR16", "robot.file"},
    {"RobotStandsElsewhere", [](auto&, auto& seen) { (*seen.robot)->state.X_BF_reported.translation().x() += 5; },
     "robot", Level::Fault, "D_WRONG_ARM", "5.00 mm apart", "tool 0"},
    {"RobotNotReady", [](auto&, auto& seen) {
       (*seen.robot)->state.ready = false;
       (*seen.robot)->state.why_not_ready = "drives off";
     }, "robot", Level::Warning, "D_NOT_READY", "drives off", "pendant"},
    {"RobotOfTheDaemonNotReady", [](auto&, auto& seen) {
       let_run(seen, {});
       seen.daemon.status.robot.why_not_ready = "drives off";
     }, "robot", Level::Warning, "D_NOT_READY", "drives off", "pendant"},
    // ---- tracker ----
    {"TrackerRefused", [](auto&, auto& seen) {
       seen.tracker = std::unexpected(drivers::TrackerError{drivers::TrackerFault::Unreachable, "no tracker answers"});
     }, "tracker", Level::Fault, "D_TRACKER", "no tracker answers", "switch the tracker on"},
    {"TrackerBusy", [](auto&, auto& seen) {
       seen.tracker = std::unexpected(drivers::TrackerError{drivers::TrackerFault::Busy, "busy"});
     }, "tracker", Level::Fault, "D_TRACKER", "busy", "other program"},
    {"TrackerCold", [](auto&, auto& seen) {
       seen.tracker = std::unexpected(drivers::TrackerError{drivers::TrackerFault::NotReady, "is heating up"});
     }, "tracker", Level::Fault, "D_TRACKER", "is heating up", "warm"},
    {"TrackerWithoutTheReflector", [](auto&, auto& seen) {
       seen.tracker = std::unexpected(drivers::TrackerError{drivers::TrackerFault::Refused, "knows no reflector \"X\""});
     }, "tracker", Level::Fault, "D_TRACKER", "knows no reflector", "tracker.reflector"},
    {"TrackerSilent", [](auto&, auto& seen) {
       seen.tracker = std::unexpected(drivers::TrackerError{drivers::TrackerFault::Timeout, "did not answer"});
     }, "tracker", Level::Fault, "D_TRACKER", "did not answer", "tracker.address"},
    {"BridgeGone", [](auto& cell, auto& seen) {
       cell.tracker.protocol = config::TrackerProtocol::Bridge;
       seen.tracker = std::unexpected(drivers::TrackerError{drivers::TrackerFault::Unreachable, "no tracker answers"});
     }, "tracker", Level::Fault, "D_TRACKER", "no tracker answers", "start the bridge"},
    {"BridgeBroken", [](auto& cell, auto& seen) {
       cell.tracker.protocol = config::TrackerProtocol::Bridge;
       cell.tracker.address = {"10.0.0.9", 7700};
       seen.tracker = std::unexpected(drivers::TrackerError{drivers::TrackerFault::Protocol, "what cannot be understood"});
     }, "tracker", Level::Fault, "D_TRACKER", "cannot be understood", "truepose bridge-check 10.0.0.9:7700"},
    {"NothingInTheBeam", [](auto&, auto& seen) {
       seen.tracker = std::unexpected(drivers::TrackerError{drivers::TrackerFault::NoTarget, "no reflector"});
     }, "tracker", Level::Fault, "D_TRACKER", "no reflector", "into the beam"},
    // ---- machine ----
    {"NoFifo", [](auto&, auto& seen) { seen.machine.fifo_refused = "Operation not permitted"; },
     "machine", Level::Warning, "D_PRIORITY", "no SCHED_FIFO 80: Operation not permitted", "rtprio"},
    {"NoFifoWhereItIsRequired", [](auto& cell, auto& seen) {
       cell.stream.realtime = config::RealtimePolicy::Require;
       seen.machine.fifo_refused = "Operation not permitted";
     }, "machine", Level::Fault, "D_PRIORITY", "no SCHED_FIFO 80", "rtprio"},
    {"DaemonWithoutFifo", [](auto&, auto& seen) {
       let_run(seen, {{"scheduling", {{"policy", "SCHED_OTHER"}, {"priority", 0}, {"cpus", {0}}, {"locked_kB", 0}}}});
     }, "machine", Level::Warning, "D_SCHEDULING", "real-time thread runs under SCHED_OTHER 0", "trueposed@CELL.service"},
    {"DaemonWithFifo", [](auto&, auto& seen) {
       let_run(seen, {{"scheduling", {{"policy", "SCHED_FIFO"}, {"priority", 80}, {"cpus", {0}}, {"locked_kB", 0}}}});
       seen.machine.fifo_refused = "the user's own limit says nothing of the unit's";
     }, "machine", Level::Ok, "D_OK", "real-time thread runs under SCHED_FIFO 80", ""},
    {"NoLock", [](auto&, auto& seen) { seen.machine.lock_refused = "Cannot allocate memory"; },
     "machine", Level::Warning, "D_LOCK", "may not lock memory", "memlock"},
    {"Governor", [](auto&, auto& seen) { seen.machine.governors = {"powersave"}; },
     "machine", Level::Warning, "D_GOVERNOR", "powersave", "performance"},
    {"SlowClock", [](auto&, auto& seen) { seen.machine.clocksource = "hpet"; },
     "machine", Level::Warning, "D_CLOCK_SOURCE", "hpet", "tsc"},
    {"ClockAdrift", [](auto&, auto& seen) { seen.machine.clock_synchronised = false; },
     "machine", Level::Warning, "D_CLOCK", "not synchronised", "chrony"},
    {"LittleRoom", [](auto&, auto& seen) { seen.machine.store_free_bytes = 500'000'000; },
     "machine", Level::Warning, "D_DISK", "demo.sqlite (limit: 1000 MB)", "make room"},
    {"NoRoom", [](auto&, auto& seen) { seen.machine.store_free_bytes = 1'000'000; },
     "machine", Level::Fault, "D_DISK", "1 MB are free", "make room"},
};
// clang-format on

class ADoctor : public testing::TestWithParam<Case> {};

TEST_P(ADoctor, Finds) {
  config::CellConfig cell = cell_in_a_plant();
  Observations seen = all_is_well(cell);
  const Case& one = GetParam();
  one.provoke(cell, seen);
  EXPECT_THAT(
      diagnose("cell.yaml", cell, seen),
      Contains(AllOf(Field(&Finding::area, one.area), Field(&Finding::level, one.level),
                     Field(&Finding::message, AllOf(Field(&Message::code, one.code),
                                                    Field(&Message::what, HasSubstr(one.finding)),
                                                    Field(&Message::what_to_do, HasSubstr(one.next)))))));
}

INSTANTIATE_TEST_SUITE_P(Provoked, ADoctor, testing::ValuesIn(kCases),
                         [](const auto& one) { return one.param.name; });

/// The other way round: of every row of the table a case shows the sentence.
TEST(FindingKinds, AreAllProvoked) {
  for (const MessageKind& kind : kFindingKinds)
    EXPECT_TRUE(std::ranges::any_of(kCases, [&](const Case& one) { return one.code == kind.code; }))
        << kind.code;
}

TEST(ADoctorOfAHealthyCell, FindsNothingButThatTheDaemonIsNotStarted) {
  const config::CellConfig cell = cell_in_a_plant();
  for (const Finding& finding : diagnose("cell.yaml", cell, all_is_well(cell))) {
    EXPECT_EQ(finding.level, finding.area == "daemon" ? Level::Fault : Level::Ok)
        << testing::PrintToString(finding);
    EXPECT_EQ(finding.message.what_to_do.empty(), finding.level == Level::Ok)
        << testing::PrintToString(finding);
  }
}

TEST(ADoctorOfAnotherCycle, NamesItBeforeAllElse) {
  const config::CellConfig cell = cell_in_a_plant();
  Observations seen = all_is_well(cell);
  seen.daemon = daemon_with(stream_with({}));
  set_cycle(seen, 40, 40);
  sender(seen).elements.names = {"RIst.X"};
  sender(seen).elements.decimals = 1;
  sender(seen).malformed = 1;
  seen.robot = std::unexpected(drivers::RobotError{drivers::RobotFault::Unreachable, "refused"});
  EXPECT_THAT(diagnose("cell.yaml", cell, seen).at(0).message.what, HasSubstr("every 40.00 ms"));
}

TEST(ADoctorOfAnotherCycle, AccusesNoSenderThatALoadedMachineStretches) {
  const config::CellConfig cell = cell_in_a_plant();
  Observations seen = all_is_well(cell);
  set_cycle(seen, 12, 4);
  sender(seen).shortest = 3900us;
  for (const Finding& one : diagnose("cell.yaml", cell, seen))
    EXPECT_THAT(one.message.what, Not(HasSubstr("its IPOC rises")));
}

/// Consequences of a cause that was found are not reported.
TEST(ADoctorOfASilentCell, NamesTheCauseAlone) {
  const config::CellConfig cell = cell_in_a_plant();
  const auto of_rsi = [&](const std::function<void(Observations&)>& provoke) {
    Observations seen = all_is_well(cell);
    silence(seen);
    provoke(seen);
    std::vector<std::string> said;
    for (const Finding& finding : diagnose("cell.yaml", cell, seen))
      if (finding.area == "rsi" && finding.level != Level::Ok) said.push_back(finding.message.what);
    return said;
  };
  EXPECT_THAT(of_rsi([](Observations& seen) { seen.interfaces[1].running = false; }),
              testing::ElementsAre(HasSubstr("has no link")));
  EXPECT_THAT(of_rsi([](Observations& seen) {
                seen.rsi.seen = {{kSource, {kPc, 49153}, 375}};
              }),
              testing::ElementsAre(HasSubstr("but stream.listen is")));
  EXPECT_THAT(
      of_rsi([](Observations& seen) {
        let_run(seen,
                {{"state", "fault"}, {"packet_age_ms", nullptr}, {"reason", "another SENTYPE: load that"}});
      }),
      testing::ElementsAre(HasSubstr("another SENTYPE")));
}

TEST(ADoctorOfAStreamThatWasLateOnce, SaysNothingOfWhatIsOver) {
  const config::CellConfig cell = cell_in_a_plant();
  for (const int late : {0, 14}) {
    Observations seen = all_is_well(cell);
    let_run(seen, last_minute("network", late));
    for (const Finding& finding : diagnose("cell.yaml", cell, seen))
      EXPECT_FALSE(finding.message.what.contains("replies")) << finding.message.what;
  }
}

TEST(ADoctor, SaysFaultsFirstAndNoLateRepliesWithANamedFaultOfRsi) {
  const config::CellConfig cell = cell_in_a_plant();
  Observations seen = all_is_well(cell);
  json::object stream = last_minute("network", 480);
  stream["state"] = "fault";
  stream["reason"] = "another SENTYPE: load that one there";
  let_run(seen, stream);
  seen.daemon.status.faults = {{"E_CELL", "error", seen.daemon.status.stream.reason}};
  const Findings findings = diagnose("cell.yaml", cell, seen);
  EXPECT_TRUE(std::ranges::is_sorted(findings, std::ranges::greater{}, &Finding::level));
  EXPECT_TRUE(std::ranges::none_of(findings,
                                   [](const Finding& f) { return f.message.what.contains("replies late"); }));
}

TEST(ADoctorOfAnotherSender, DoesNotJudgeItAsTheController) {
  config::CellConfig cell = cell_in_a_plant();
  Observations seen = all_is_well(cell);
  cell.robot.rsi_peer = "192.168.44.2";
  sender(seen).elements.names = {"RIst.X", "AIPoz.A1"};
  sender(seen).malformed = 3;
  std::vector<std::string> said;
  for (const Finding& finding : diagnose("cell.yaml", cell, seen))
    if (finding.area == "rsi") said.push_back(finding.message.what);
  EXPECT_THAT(said, testing::ElementsAre(HasSubstr("packets of 192.168.44.1:52000 are dropped")));
}

TEST(ADoctorOfRoundedAxes, AccusesNoOtherArm) {
  const config::CellConfig cell = cell_in_a_plant();
  for (const double off_mm : {0.0, 8.0, 300.0}) {
    Observations seen = all_is_well(cell);
    sender(seen).elements.decimals = 1;
    sender(seen).frame.rist->x_mm += off_mm;
    const Findings findings = diagnose("cell.yaml", cell, seen);
    const bool accused =
        std::ranges::any_of(findings, [](const Finding& f) { return f.message.what.contains("RIst is"); });
    EXPECT_EQ(accused, off_mm > 100) << off_mm;
  }
}

}  // namespace
}  // namespace truepose::tools
