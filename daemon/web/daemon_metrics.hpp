#pragma once

#include <chrono>
#include <cstddef>
#include <string>

#include "daemon/cell/daemon_cell.hpp"
#include "daemon/control/control_server.hpp"
#include "daemon/realtime/stream_cycle.hpp"

namespace truepose::daemon {

/// What of the daemon is measured over time, as it is now.
struct DaemonMeasures {
  std::string cell;  ///< its name
  DaemonCell::Snapshot snapshot;
  const StreamCycle& stream;
  ControlLoad control;
  std::size_t web_connections = 0;
  std::uint64_t events = 0;         ///< number of the event that is published next
  std::size_t store_bytes = 0;      ///< of its files
  std::uint64_t store_jobs = 0;     ///< done since the start
  std::uint64_t store_waiting = 0;  ///< jobs that wait or are under way
  std::chrono::duration<double> uptime{};
  drivers::TimePoint now{};
};

/// The metrics as Prometheus reads them.
std::string metrics_text(const DaemonMeasures& measures);

}  // namespace truepose::daemon
