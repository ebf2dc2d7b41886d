#pragma once

#include <array>

#include "proto/text/message.hpp"

namespace truepose::tools {

/// What the doctor may find, in the order of their codes. A fault of the daemon keeps its code, and what the
/// linter finds too has that kind.
enum class FindingKind {
  AxisLimit,
  CardOff,
  CellFile,
  Clock,
  ClockSource,
  Cycle,
  CycleAndIpoc,
  CycleOfSender,
  Daemon,
  Disk,
  Dropped,
  Elements,
  Firewall,
  Governor,
  Late,
  LateByDaemon,
  LateByMachine,
  LateByNetwork,
  Listen,
  Lock,
  Losses,
  Malformed,
  Network,
  NotReady,
  NoLink,
  NoPacket,
  PortTaken,
  Priority,
  Robot,
  Scheduling,
  Sender,
  Stream,
  Target,
  Tracker,
  Version,
  WrongArm,
};

// What several kinds share.
inline constexpr std::string_view kOtherCycle =
    "{0} sends packets{1}, its IPOC rises by {2}, and stream.cycle_ms is {3:.0f}";
inline constexpr std::string_view kLookAtNetwork =
    "look at cable, switch and other traffic of the RSI network";
inline constexpr std::string_view kLoadOurs = "load {0} on the controller, and start its RSI program again";
inline constexpr std::string_view kStartAsService =
    "start the daemon as trueposed@CELL.service, or raise the limits rtprio and memlock (ulimit -r and -l)";

inline constexpr std::array kFindingKinds{
    MessageKind{"D_AXIS_LIMIT", "A{0} is at {1:.1f} deg, outside the robot file's {2:.1f} to {3:.1f} deg",
                "correct robot.file: it is another arm's, or its limits are not the controller's"},
    MessageKind{"D_CARD_OFF", "{0}, which has {1}, is switched off", "switch it on: ip link set {0} up"},
    MessageKind{"D_CELL_FILE", "{0}", "correct it, and run: trueposed --config {1} --check"},
    MessageKind{"D_CLOCK", "the clock of this PC is not synchronised: times in store and log may be wrong",
                "switch on chrony or systemd-timesyncd"},
    MessageKind{"D_CLOCK_SOURCE", "the clock of this PC is {0}, which is slow to read",
                "look why the kernel does not use tsc: dmesg | grep -i tsc"},
    MessageKind{"D_CYCLE", kOtherCycle, "set stream.cycle_ms to {4:.0f} and restart trueposed{5}"},
    MessageKind{
        "D_CYCLE_AND_IPOC", kOtherCycle,
        "make the sender send every {4:.0f} ms, as its IPOC counts, and set stream.cycle_ms to {4:.0f} and "
        "restart trueposed"},
    MessageKind{"D_CYCLE_OF_SENDER", kOtherCycle,
                "make the sender send every {4:.0f} ms, as its IPOC counts, or correct its IPOC and "
                "stream.cycle_ms"},
    MessageKind{"D_DAEMON", "{0}", "start it: systemctl start trueposed@CELL, or trueposed --config {1}"},
    MessageKind{"D_DISK", "{0:.0f} MB are free for {1} (limit: {2:.0f} MB)", "make room on that disk"},
    MessageKind{
        "D_DROPPED",
        "{0} sends RSI packets to {1}, and they do not come through; no rule of a firewall was found",
        "look at what drops them: as root, nft list ruleset, and sysctl net.ipv4.conf.all.rp_filter, by "
        "which Linux drops what comes from a network that it would not answer to"},
    MessageKind{"D_ELEMENTS", "{1} sends other elements than the ethernet configuration says{2}", kLoadOurs},
    MessageKind{"D_FIREWALL", "{0}the firewall of this PC has \"{1}\"", "let UDP port {2} in"},
    MessageKind{"D_GOVERNOR", "processors run by the governor \"{0}\", which wakes them late",
                "run: cpupower frequency-set -g performance"},
    MessageKind{"D_LATE", "replies that were not with the controller in time (Delay): {0}",
                "look at the findings about this machine, then at cable and switch of the RSI network"},
    MessageKind{"D_LATE_BY_DAEMON", "replies late by truepose's own fault: {0}",
                "send the log and `truepose status --json` to its makers"},
    MessageKind{"D_LATE_BY_MACHINE", "replies late because this PC did not run truepose in time: {0}",
                "give it a processor and its priority: look at the findings about this machine"},
    MessageKind{"D_LATE_BY_NETWORK", "replies late because of the network or the controller: {0}",
                kLookAtNetwork},
    MessageKind{"D_LISTEN", "{0}", "make stream.listen an address of this PC ({1})"},
    MessageKind{"D_LOCK", "this user may not lock memory: {0}", kStartAsService},
    MessageKind{"D_LOSSES", "{0:.1f} % of the packets of {1} did not arrive", kLookAtNetwork},
    MessageKind{"D_MALFORMED", "packets of {1} cannot be understood ({2} so far): {3}", kLoadOurs},
    MessageKind{
        "D_NETWORK", "robot.rsi_peer {0} is not in the network of {1}, {2}",
        "give controller and PC addresses in one RSI network, which is not the controller's other one"},
    MessageKind{"D_NOT_READY", "{0}, is not ready: {1}", "remove the cause at the pendant"},
    MessageKind{"D_NO_LINK", "{0}, which has {1}, has no link",
                "plug in the cable to the controller's RSI network"},
    MessageKind{
        "D_NO_PACKET", "no RSI packet comes to {0} ({1} so far){2}",
        "start the program on the controller: it must have come to RSI_ON; where the pendant shows "
        "RSITimeout it has, and IP_NUMBER or PORT there, or the controller's RSI network, are others"},
    MessageKind{"D_PORT_TAKEN", "{0}",
                "end that process; if it is trueposed itself, run truepose doctor as a user whom it lets in"},
    MessageKind{"D_PRIORITY", "this user gets no SCHED_FIFO {0}: {1}", kStartAsService},
    MessageKind{"D_ROBOT", "{0}", "{1}"},
    MessageKind{"D_SCHEDULING", "the daemon's real-time thread runs under {0} {1}", kStartAsService},
    MessageKind{"D_SENDER", "packets of {0} are dropped: the controller is expected at {1} (robot.rsi_peer)",
                "give the controller's address in the RSI network as robot.rsi_peer, or stop that sender"},
    MessageKind{"D_STREAM", "{0}", "{1}"},
    MessageKind{"D_TARGET", "{0} sends RSI packets to {1}, but stream.listen is {2}",
                "make IP_NUMBER and PORT of the configuration on the controller {2}, or stream.listen {1}"},
    MessageKind{"D_TRACKER", "{0}", "{1}"},
    MessageKind{"D_VERSION", "trueposed runs in version {0}, and this is truepose {1}",
                "restart the daemon: systemctl restart trueposed@CELL"},
    MessageKind{"D_WRONG_ARM", "{0}", "{1}"},
};

constexpr const MessageKind& kind_of(FindingKind kind) {
  return kFindingKinds[static_cast<std::size_t>(kind)];
}
static_assert(is_table(kFindingKinds, "D_") && kind_of(FindingKind::WrongArm).code == "D_WRONG_ARM");

}  // namespace truepose::tools
