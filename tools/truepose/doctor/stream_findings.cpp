#include <algorithm>

#include "core/formatted.hpp"
#include "tools/truepose/doctor/diagnose.hpp"

namespace truepose::tools {

namespace {

using Kind = FindingKind;

// Of the replies of the last minute; one in a thousand is what any network does.
constexpr double kLateShare = 0.001;

/// "3.2 % of the last minute's 15000"; empty: not worth a word.
std::string late_share(std::uint64_t replies, std::uint64_t late) {
  const auto all = static_cast<double>(replies), part = static_cast<double>(late);
  if (all == 0 || part < kLateShare * all) return {};
  return formatted("%.1f %% of the last minute's %.0f", 100 * part / all, all);
}

Findings late_findings(const rpc::StreamStatus::LastMinute& minute) {
  Findings findings;
  const auto add = [&]<Kind kKind>(std::uint64_t late) {
    const std::string share = late_share(minute.answered, late);
    if (share.empty()) return;
    findings.push_back(finding<kKind>("rsi", Level::Warning, share));
    findings.back().may_follow = true;
  };
  add.operator()<Kind::LateByDaemon>(minute.daemon);
  add.operator()<Kind::LateByMachine>(minute.machine);
  add.operator()<Kind::LateByNetwork>(minute.network);
  if (findings.empty()) add.operator()<Kind::Late>(minute.late);
  return findings;
}

/// Whether the operator has to fix the stream's reason, rather than wait.
bool is_fault(const rpc::CellStatus& status, const std::string& reason) {
  return reason.contains("acknowledge") ||
         std::ranges::find(status.faults, reason, &rpc::Fault::text) != status.faults.end();
}

}  // namespace

Findings stream_findings(const config::CellConfig& cell, const rpc::CellStatus& status) {
  Findings findings;
  const rpc::StreamStatus& stream = status.stream;
  // Where nothing came, the daemon says no more than to ask the doctor.
  if (!stream.reason.empty() && !stream.reason.contains("truepose doctor"))
    findings.push_back(
        from_sentence("rsi", is_fault(status, stream.reason) ? Level::Fault : Level::Warning, stream.reason));
  if (stream.refused) {
    const bool foreign = stream.malformed == 0;
    if (foreign) {
      findings.push_back(
          from_sentence("rsi", Level::Fault, *stream.refused, std::string{kind_of(Kind::Sender).code}));
    } else {
      findings.push_back(
          finding<Kind::Malformed>("rsi", Level::Fault, cell.stream.ethernet_xml.string(), "", 0, ""));
      findings.back().message.what = *stream.refused;
    }
  }
  const std::vector<Finding> late = late_findings(stream.last_minute);
  findings.insert(findings.end(), late.begin(), late.end());
  if (findings.empty() && stream.answered > 0)
    findings.push_back(
        good("rsi", "the controller's packets are answered: " + std::to_string(stream.answered)));
  return findings;
}

}  // namespace truepose::tools
