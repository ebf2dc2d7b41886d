#include <algorithm>
#include <boost/json/array.hpp>

#include "core/formatted.hpp"
#include "tools/truepose/doctor/diagnose.hpp"
#include "tools/truepose/text.hpp"

namespace truepose::tools {

namespace json = boost::json;

namespace {

double count_at(const json::value& stream, std::string_view pointer) {
  const json::value* found = find_at(stream, pointer);
  return found && found->is_number() ? found->to_number<double>() : 0;
}

using Kind = FindingKind;

// Of the replies of the last minute; one in a thousand is what any network does.
constexpr double kLateShare = 0.001;

/// "3.2 % of the last minute's 15000"; empty: not worth a word.
std::string late_share(const json::value& stream, const char* pointer) {
  const double replies = count_at(stream, "/last_minute/answered"), late = count_at(stream, pointer);
  if (replies == 0 || late < kLateShare * replies) return {};
  return formatted("%.1f %% of the last minute's %.0f", 100 * late / replies, replies);
}

Findings late_findings(const json::value& stream) {
  Findings findings;
  const auto add = [&]<Kind kKind>(const char* pointer) {
    const std::string share = late_share(stream, pointer);
    if (share.empty()) return;
    findings.push_back(finding<kKind>("rsi", Level::Warning, share));
    findings.back().may_follow = true;
  };
  add.operator()<Kind::LateByDaemon>("/last_minute/daemon");
  add.operator()<Kind::LateByMachine>("/last_minute/machine");
  add.operator()<Kind::LateByNetwork>("/last_minute/network");
  if (findings.empty()) add.operator()<Kind::Late>("/last_minute/late");
  return findings;
}

/// Whether the operator has to fix the stream's reason, rather than wait.
bool is_fault(const json::value& status, const std::string& reason) {
  if (reason.contains("acknowledge")) return true;
  const json::array& faults = list_at(status, "/faults");
  return std::ranges::any_of(faults,
                             [&](const json::value& fault) { return string_at(fault, "/text") == reason; });
}

}  // namespace

Findings stream_findings(const config::CellConfig& cell, const json::value& status) {
  Findings findings;
  const json::value& stream = status.at("stream");
  // Where nothing came, the daemon says no more than to ask the doctor.
  const std::string reason = string_at(stream, "/reason");
  if (!reason.empty() && !reason.contains("truepose doctor"))
    findings.push_back(
        from_sentence("rsi", is_fault(status, reason) ? Level::Fault : Level::Warning, reason));
  if (const std::string refused = string_at(stream, "/refused"); !refused.empty()) {
    const bool foreign = count_at(stream, "/malformed") == 0;
    if (foreign) {
      findings.push_back(
          from_sentence("rsi", Level::Fault, refused, std::string{kind_of(Kind::Sender).code}));
    } else {
      findings.push_back(
          finding<Kind::Malformed>("rsi", Level::Fault, cell.stream.ethernet_xml.string(), "", 0, ""));
      findings.back().message.what = refused;
    }
  }
  const std::vector<Finding> late = late_findings(stream);
  findings.insert(findings.end(), late.begin(), late.end());
  if (findings.empty() && count_at(stream, "/answered") > 0)
    findings.push_back(good("rsi", "the controller's packets are answered: " + text_at(stream, "/answered")));
  return findings;
}

}  // namespace truepose::tools
