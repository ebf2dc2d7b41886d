#include "tools/truepose/doctor/diagnose.hpp"

#include <algorithm>
#include <functional>
#include <iterator>

namespace truepose::tools {

namespace {

using Kind = FindingKind;

Level level_of(daemon::CheckFinding::Level level) {
  switch (level) {
    case daemon::CheckFinding::Level::Good:
      return Level::Ok;
    case daemon::CheckFinding::Level::Warning:
      return Level::Warning;
    case daemon::CheckFinding::Level::Failure:
      return Level::Fault;
  }
  return Level::Fault;
}

Findings check_findings(const std::string& file, const std::vector<daemon::CheckFinding>& check) {
  Findings findings;
  for (const daemon::CheckFinding& one : check) {
    const Level level = level_of(one.level);
    findings.push_back(level == Level::Ok ? good("cell file", one.text)
                                          : finding<Kind::CellFile>("cell file", level, one.text, file));
  }
  return findings;
}

void add(Findings& findings, Findings more) { std::ranges::move(more, std::back_inserter(findings)); }

/// Of the daemon's faults, but those that its stream gives as its reason.
Findings fault_findings(const rpc::CellStatus& status) {
  Findings findings;
  for (const auto& [code, severity, text, since] : status.faults) {
    const bool frozen = code == "E_STREAM_FROZEN" && !status.stream.reason.empty();
    if (frozen || text == status.stream.reason) continue;
    const Level level = severity == "warning" ? Level::Warning : Level::Fault;
    findings.push_back(from_sentence(code == "E_TRACKER" ? "tracker" : "daemon", level, text, code));
  }
  return findings;
}

/// Without what may follow from a fault that is named.
void suppress_consequences(Findings& findings) {
  std::vector<std::string> at_fault;
  for (const Finding& finding : findings) {
    if (finding.level == Level::Fault && !finding.may_follow) at_fault.push_back(finding.area);
  }
  std::erase_if(findings, [&](const Finding& finding) {
    return finding.may_follow && std::ranges::find(at_fault, finding.area) != at_fault.end();
  });
}

}  // namespace

Finding from_sentence(std::string area, Level level, const std::string& sentence, std::string code) {
  const std::size_t end = std::max(sentence.rfind(": ") + 1, sentence.rfind("; ") + 1);
  Finding found =
      finding<Kind::Stream>(std::move(area), level, end == 0 ? sentence : sentence.substr(0, end - 1),
                            end == 0 ? "run: truepose status" : sentence.substr(end + 1));
  if (!code.empty()) found.message.code = std::move(code);
  return found;
}

Findings daemon_findings(const std::string& file, const DaemonObservation& daemon) {
  if (!daemon.unreachable.empty())
    return {finding<Kind::Daemon>("daemon", Level::Fault, daemon.unreachable, file)};
  if (daemon.version != TRUEPOSE_VERSION)
    return {finding<Kind::Version>("daemon", Level::Warning, daemon.version, TRUEPOSE_VERSION)};
  Findings findings{good("daemon", "trueposed " + daemon.version + " runs, state " + daemon.status.state)};
  add(findings, fault_findings(daemon.status));
  return findings;
}

Findings diagnose(const std::string& file, const config::CellConfig& cell, const Observations& seen) {
  Findings findings = check_findings(file, seen.check);
  // A daemon cannot start where another program has its port.
  const bool port_lost = seen.rsi.taken && !seen.rsi.not_bound.contains("trueposed");
  if (!port_lost) add(findings, daemon_findings(file, seen.daemon));
  add(findings, stream_findings(cell, seen.daemon.status));
  add(findings, rsi_findings(cell, seen));
  add(findings, robot_findings(cell, seen));
  add(findings, tracker_findings(cell, seen));
  add(findings, machine_findings(cell, seen));
  suppress_consequences(findings);
  std::ranges::stable_sort(findings, std::ranges::greater{}, &Finding::level);
  return findings;
}

}  // namespace truepose::tools
