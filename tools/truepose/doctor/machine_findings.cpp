#include <algorithm>

#include "core/formatted.hpp"
#include "tools/truepose/doctor/diagnose.hpp"
#include "tools/truepose/doctor/network.hpp"

namespace truepose::tools {

namespace {

constexpr double kMegabyte = 1e6;
constexpr double kLittle_MB = 1000, kTooLittle_MB = 50;

using Kind = FindingKind;

/// As the kernel tells it of the daemon that runs.
Finding thread_finding(Level level, const rpc::StreamScheduling& thread) {
  const std::string priority = std::to_string(thread.priority);
  if (thread.policy == "SCHED_FIFO")
    return good("machine", "the daemon's real-time thread runs under " + thread.policy + " " + priority);
  return finding<Kind::Scheduling>("machine", level, thread.policy, priority);
}

/// The unit raises these limits for the daemon; a user that starts it by hand has to raise them.
Findings limit_findings(Level level, const config::StreamConfig& stream, const MachineObservation& machine) {
  Findings findings;
  if (!machine.fifo_refused.empty())
    findings.push_back(finding<Kind::Priority>("machine", level, stream.priority, machine.fifo_refused));
  if (!machine.lock_refused.empty())
    findings.push_back(finding<Kind::Lock>("machine", level, machine.lock_refused));
  if (findings.empty())
    findings.push_back(
        good("machine", "SCHED_FIFO " + std::to_string(stream.priority) + " and locked memory can be had"));
  return findings;
}

Findings realtime_findings(const config::StreamConfig& stream, const Observations& seen) {
  if (stream.realtime == config::RealtimePolicy::Off) return {};
  const Level level = stream.realtime == config::RealtimePolicy::Require ? Level::Fault : Level::Warning;
  if (const auto& thread = seen.daemon.status.stream.scheduling) return {thread_finding(level, *thread)};
  return limit_findings(level, stream, seen.machine);
}

/// What this PC was prepared with.
Finding kernel_finding(const MachineObservation& machine) {
  return good("machine", std::string{"the kernel is "} + (machine.preempt_rt ? "" : "not ") +
                             "PREEMPT_RT; isolated processors: " +
                             (machine.isolated.empty() ? "none" : machine.isolated));
}

Findings clock_findings(const MachineObservation& machine) {
  Findings findings;
  if (!machine.clocksource.empty() && machine.clocksource != "tsc" && !machine.clocksource.starts_with("kvm"))
    findings.push_back(finding<Kind::ClockSource>("machine", Level::Warning, machine.clocksource));
  if (!machine.clock_synchronised) findings.push_back(finding<Kind::Clock>("machine", Level::Warning));
  return findings;
}

Findings governor_findings(const MachineObservation& machine) {
  Findings findings;
  for (const std::string& governor : machine.governors) {
    if (governor != "performance")
      findings.push_back(finding<Kind::Governor>("machine", Level::Warning, governor));
  }
  return findings;
}

Findings disk_findings(const config::CellConfig& cell, const MachineObservation& machine) {
  if (!machine.store_free_bytes) return {};
  const double free_MB = static_cast<double>(*machine.store_free_bytes) / kMegabyte;
  const std::string store = cell.store.string();
  if (free_MB >= kLittle_MB) return {good("machine", formatted("%.0f MB are free for ", free_MB) + store)};
  return {finding<Kind::Disk>("machine", free_MB < kTooLittle_MB ? Level::Fault : Level::Warning, free_MB,
                              store, kLittle_MB)};
}

}  // namespace

Findings machine_findings(const config::CellConfig& cell, const Observations& seen) {
  Findings findings{good("machine", "its addresses: " + addresses_text(seen.interfaces))};
  for (const Findings& part :
       {realtime_findings(cell.stream, seen), Findings{kernel_finding(seen.machine)},
        governor_findings(seen.machine), clock_findings(seen.machine), disk_findings(cell, seen.machine)})
    findings.insert(findings.end(), part.begin(), part.end());
  return findings;
}

}  // namespace truepose::tools
