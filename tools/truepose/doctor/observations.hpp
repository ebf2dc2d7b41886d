#pragma once

#include <cstdint>
#include <expected>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "config/cell_config.hpp"
#include "daemon/check.hpp"
#include "daemon/device_probe.hpp"
#include "drivers/kuka/udp_source.hpp"
#include "proto/rpc/cell.hpp"
#include "proto/rsi/ethernet_config.hpp"
#include "tools/truepose/doctor/rsi_watch.hpp"

namespace truepose::tools {

/// An IPv4 address of this PC.
struct Interface {
  std::string name;
  std::uint32_t address = 0, mask = 0;
  bool up = true;       ///< switched on
  bool running = true;  ///< something is at the other end of the cable
};

/// RSI datagrams that came to this PC, wherever they were for and whether a firewall let them in or not.
struct SeenStream {
  drivers::UdpSource source, target;
  std::uint64_t datagrams = 0;
};

struct DaemonObservation {
  std::string unreachable;  ///< why; empty: it answers
  std::string version;
  rpc::CellStatus status{};  ///< as the daemon itself says it; empty where it does not, or is of another form
};

/// The RSI port as it was for a while. Where the daemon has it, root alone sees what passes by.
struct RsiObservation {
  std::string not_bound;  ///< why we could not listen, where no daemon answers
  bool taken = false;     ///< because another program has the port
  std::vector<RsiSender> senders;
  std::optional<std::vector<SeenStream>>
      seen;                     ///< to ports that no program has, or to ours; none: only root may look
  std::uint64_t unclaimed = 0;  ///< datagrams of any kind to ports that no program has
  std::optional<std::string> firewall;  ///< its rules as nft or iptables print them; none: unreadable
};

/// What this PC is like for work in real time.
struct MachineObservation {
  std::string fifo_refused;            ///< why SCHED_FIFO at stream.priority cannot be had; empty: it can
  std::string lock_refused;            ///< why memory cannot be locked
  std::vector<std::string> governors;  ///< of its processors, each once; empty: not readable
  bool preempt_rt = false;
  std::string isolated;     ///< processors kept free for us: "2-3"
  std::string clocksource;  ///< "tsc"
  bool clock_synchronised = true;
  std::optional<std::uint64_t> store_free_bytes;
};

struct Observations {
  std::vector<daemon::CheckFinding> check;  ///< of `trueposed --config FILE --check`
  std::optional<rsi::EthernetConfig> ethernet;
  std::vector<Interface> interfaces;
  DaemonObservation daemon;
  RsiObservation rsi;
  /// None: not asked, because the daemon is connected, or its stream is armed.
  std::optional<std::expected<daemon::RobotObservation, drivers::RobotError>> robot;
  std::optional<std::expected<drivers::TrackerIdentity, drivers::TrackerError>> tracker;
  MachineObservation machine;
};

}  // namespace truepose::tools
