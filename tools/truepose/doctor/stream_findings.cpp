#include <algorithm>
#include <array>
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

/// Why replies were late, and what to do about it.
struct Cause {
  const char *pointer, *why, *next;
};
// Of the replies of the last minute; one in a thousand is what any network does.
constexpr double kLateShare = 0.001;
constexpr std::array kCauses{
    Cause{"/last_minute/daemon", "by truepose's own fault",
          "send the log and `truepose status --json` to its makers"},
    Cause{"/last_minute/machine", "because this PC did not run truepose in time",
          "give it a processor and its priority: look at the findings about this machine"},
    Cause{"/last_minute/network", "because of the network or the controller",
          "look at cable, switch and other traffic of the RSI network"}};

/// "3.2 % of the last minute's 15000"; empty: not worth a word.
std::string late_share(const json::value& stream, const char* pointer) {
  const double replies = count_at(stream, "/last_minute/answered"), late = count_at(stream, pointer);
  if (replies == 0 || late < kLateShare * replies) return {};
  return formatted("%.1f %% of the last minute's %.0f", 100 * late / replies, replies);
}

Findings late_findings(const json::value& stream) {
  Findings findings;
  const auto say = [&](const std::string& finding, const char* next) {
    findings.push_back({"rsi", Level::Warning, finding, next, true});
  };
  for (const Cause& cause : kCauses) {
    if (const std::string share = late_share(stream, cause.pointer); !share.empty())
      say(std::string{"replies late "} + cause.why + ": " + share, cause.next);
  }
  const std::string share = late_share(stream, "/last_minute/late");
  if (findings.empty() && !share.empty())
    say("replies that were not with the controller in time (Delay): " + share,
        "look at the findings about this machine, then at cable and switch of the RSI network");
  return findings;
}

/// Whether somebody has to mend what the stream gives as its reason, rather than wait.
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
    findings.push_back({"rsi", Level::Fault, refused,
                        foreign ? "give the controller's address as robot.rsi_peer, or stop that sender"
                                : "load " + cell.stream.ethernet_xml.string() +
                                      " on the controller, and start its RSI program again"});
  }
  const std::vector<Finding> late = late_findings(stream);
  findings.insert(findings.end(), late.begin(), late.end());
  if (findings.empty() && count_at(stream, "/answered") > 0)
    findings.push_back(
        {"rsi", Level::Ok, "the controller's packets are answered: " + text_at(stream, "/answered"), ""});
  return findings;
}

}  // namespace truepose::tools
