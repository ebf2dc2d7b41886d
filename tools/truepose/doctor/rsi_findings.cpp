#include <algorithm>
#include <chrono>
#include <cmath>
#include <iterator>

#include "core/formatted.hpp"
#include "core/math/units.hpp"
#include "daemon/realtime/stream_checks.hpp"
#include "daemon/realtime/stream_options.hpp"
#include "tools/truepose/doctor/diagnose.hpp"
#include "tools/truepose/doctor/network.hpp"
#include "tools/truepose/text.hpp"

namespace truepose::tools {

namespace {

constexpr int kLeastDecimals = 4;
constexpr double kLost = 0.01;  // share of the controller's cycles
// By such a factor two periods differ; of fewer cycles no period is measured.
constexpr double kOtherPeriod = 2;
constexpr std::uint64_t kMeasuredCycles = 10;
constexpr std::uint64_t kIpocOfKrC2 = 1;  // from cycle to cycle
constexpr double kFastCycle_ms = 4, kIpoCycle_ms = 12;

std::string listed(const std::vector<std::string>& names) {
  std::string list;
  for (const std::string& name : names) list += (list.empty() ? "" : ", ") + name;
  return list;
}

/// The findings about one sender, beside what all of them need.
class SenderFindings {
 public:
  /// @param told_by_daemon  that packets of another sender are dropped
  SenderFindings(const config::CellConfig& cell, const std::optional<rsi::EthernetConfig>& ethernet,
                 const RsiSender& sender, bool told_by_daemon)
      : cell_{cell},
        ethernet_{ethernet},
        sender_{sender},
        told_by_daemon_{told_by_daemon},
        from_{text(sender.source)} {}

  Findings all() {
    look_at_address();
    if (is_another_) return findings_;  // what it sends is not the controller's
    look_at_cycle();
    look_at_malformed();
    if (sender_.frames == 0) return findings_;
    look_at_names();
    look_at_decimals();
    look_at_arm();
    look_at_limits();
    look_at_losses();
    if (findings_.empty())
      say(Level::Ok,
          from_ + " sends good frames every " + formatted("%.2f ms", sender_.cycle_ms().value_or(0)), "");
    return findings_;
  }

 private:
  void say(Level level, std::string finding, std::string next) {
    findings_.push_back({"rsi", level, std::move(finding), std::move(next)});
  }

  std::string load_ours() const {
    return "load " + cell_.stream.ethernet_xml.string() +
           " on the controller, and start its RSI program again";
  }

  void look_at_address() {
    const auto peer = drivers::ipv4_of(cell_.robot.rsi_peer);
    if (!peer || *peer == sender_.source.address) return;
    is_another_ = true;
    if (told_by_daemon_) return;
    say(Level::Fault,
        "packets come from " + from_ + ", and the controller is expected at " + cell_.robot.rsi_peer +
            " (robot.rsi_peer): the daemon drops them",
        "give the controller's address in the RSI network as robot.rsi_peer, or stop that sender");
  }

  /// Measured by the IPOC, so lost packets do not count; none where too few cycles came.
  std::optional<double> period_ms() const {
    if (sender_.ipoc_step == 0) return std::nullopt;
    const std::uint64_t cycles = (sender_.ipoc - sender_.ipoc_begin) / sender_.ipoc_step;
    if (cycles < kMeasuredCycles) return std::nullopt;
    return std::chrono::duration<double, std::milli>(sender_.last - sender_.first).count() /
           static_cast<double>(cycles);
  }

  /// Another cycle than the configured one explains nearly all else that is found.
  void look_at_cycle() {
    const auto configured_ms = static_cast<double>(cell_.stream.cycle.count());
    const auto measured_ms = period_ms();
    const bool counts_ms = sender_.ipoc_step > kIpocOfKrC2;
    const auto ipoc_ms = counts_ms     ? std::optional{static_cast<double>(sender_.ipoc_step)}
                         : measured_ms ? std::optional{std::round(*measured_ms)}
                                       : std::nullopt;
    if (!ipoc_ms) return;
    // A loaded machine stretches some gaps of a sender, and not the shortest.
    const auto shortest_ms =
        std::chrono::duration<double, std::milli>(sender_.shortest.value_or(drivers::Duration{0})).count();
    const bool is_slow = measured_ms && shortest_ms > kOtherPeriod * *ipoc_ms;
    const bool is_off = is_slow || (measured_ms && kOtherPeriod * *measured_ms < *ipoc_ms);
    if (*ipoc_ms == configured_ms && !is_off) return;
    const std::string measured = measured_ms ? formatted("every %.2f ms", *measured_ms) : "";
    std::string next = formatted("set stream.cycle_ms to %.0f and restart trueposed", *ipoc_ms);
    if (is_off) {
      next = formatted("make the sender send every %.0f ms, as its IPOC counts, ", *ipoc_ms) +
             (*ipoc_ms == configured_ms ? "or correct its IPOC and stream.cycle_ms" : "and " + next);
    } else if (configured_ms == kFastCycle_ms || configured_ms == kIpoCycle_ms) {
      next += std::string{", or start RSI with "} + (configured_ms == kFastCycle_ms ? "#IPO_FAST" : "#IPO");
    }
    say(Level::Fault,
        from_ + " sends packets" + (measured.empty() ? "" : " " + measured) + ", its IPOC rises by " +
            std::to_string(sender_.ipoc_step) + formatted(", and stream.cycle_ms is %.0f", configured_ms),
        next);
  }

  void look_at_malformed() {
    if (sender_.malformed == 0) return;
    say(sender_.frames == 0 ? Level::Fault : Level::Warning,
        "packets of " + from_ + " cannot be understood (" + std::to_string(sender_.malformed) +
            " so far): " + sender_.why_malformed,
        load_ours());
  }

  void look_at_names() {
    if (!ethernet_) return;
    const rsi::NameDifference names = compare_names(sender_.elements, *ethernet_);
    if (names == rsi::NameDifference{}) return;
    std::string finding = from_ + " sends other elements than the ethernet configuration says";
    if (!names.unknown.empty()) finding += "; not in it: " + listed(names.unknown);
    if (!names.missing.empty()) finding += "; not sent: " + listed(names.missing);
    say(names.missing.empty() ? Level::Warning : Level::Fault, finding, load_ours());
  }

  void look_at_decimals() {
    if (sender_.elements.decimals >= kLeastDecimals) return;
    say(Level::Warning,
        from_ + " sends with Precision " + std::to_string(sender_.elements.decimals) +
            ": the axes are rounded",
        "set Precision of the ETHERNET object in the RSI context to " + std::to_string(kLeastDecimals));
  }

  /// How far the pose of a flange is off for axes and lengths that are rounded, at most.
  double rounding_mm() const {
    const double step = 0.5 * std::pow(10, -sender_.elements.decimals);  // deg and mm
    double reach_mm = 0;
    for (const Joint& joint : cell_.robot.model.joints)
      reach_mm += std::abs(joint.a_mm) + std::abs(joint.d_mm);
    return step * std::sqrt(3.0) + step * kRadPerDeg * reach_mm * cell_.robot.model.joint_count();
  }

  /// As the stream will judge it, but for what few decimals do.
  void look_at_arm() {
    const double rounded_mm = sender_.elements.decimals < kLeastDecimals ? rounding_mm() : 0;
    daemon::ArmCheck check{cell_.robot.model, cell_.stream.cycle,
                           cell_.robot.max_fk_deviation_mm + rounded_mm};
    if (const auto found = check.arm(sender_.frame, 0))
      findings_.push_back(from_sentence("rsi", Level::Fault,
                                        daemon::reason({.fault = found->fault, .detail = found->detail})));
  }

  void look_at_limits() {
    const auto& axes = sender_.frame.aipos_rad;
    const auto& joints = cell_.robot.model.joints;
    if (!axes) return;
    for (std::size_t i = 0; i < std::min(axes->size(), joints.size()); ++i) {
      const double q = (*axes)[i];
      if (q >= joints[i].min && q <= joints[i].max) continue;
      say(Level::Warning,
          "A" + std::to_string(i + 1) + " is at " + formatted("%.1f deg", q * kDegPerRad) +
              ", outside the robot file's " + formatted("%.1f to ", joints[i].min * kDegPerRad) +
              formatted("%.1f deg", joints[i].max * kDegPerRad),
          "correct robot.file: it is another arm's, or its limits are not the controller's");
    }
  }

  void look_at_losses() {
    if (sender_.ipoc_step == 0) return;
    const auto cycles = static_cast<double>((sender_.ipoc - sender_.ipoc_begin) / sender_.ipoc_step + 1);
    const double lost = 1 - static_cast<double>(sender_.frames) / cycles;
    if (lost < kLost) return;
    say(Level::Warning, formatted("%.1f %% of the packets of ", 100 * lost) + from_ + " did not arrive",
        "look at cable, switch and other traffic of the RSI network");
    findings_.back().may_follow = true;
  }

  const config::CellConfig& cell_;
  const std::optional<rsi::EthernetConfig>& ethernet_;
  const RsiSender& sender_;
  bool told_by_daemon_;
  bool is_another_ = false;  // than the controller
  std::string from_;
  Findings findings_;
};

// ---- Nothing could come ----

Finding not_bound(const Observations& seen) {
  const std::string next =
      seen.rsi.taken
          ? "end that process; if it is trueposed itself, run truepose doctor as a user whom it lets in"
          : "this PC has " + addresses_text(seen.interfaces) + ": make stream.listen one of them";
  return {"rsi", Level::Fault, seen.rsi.not_bound, next};
}

// ---- Nothing came ----

/// @param dropping  the firewall's rules that may drop what comes to the port
Finding elsewhere(const config::CellConfig& cell, const SeenStream& stream,
                  const std::vector<std::string>& dropping) {
  const std::string listen = config::text(cell.stream.listen);
  const std::string sends = text(stream.source) + " sends RSI packets to " + text(stream.target);
  const bool address = drivers::ipv4_of(cell.stream.listen.host) == stream.target.address ||
                       cell.stream.listen.host == "0.0.0.0";
  if (address && stream.target.port == cell.stream.listen.port) {
    if (!dropping.empty())
      return {
          "rsi", Level::Fault,
          sends + ", and they do not come through: the firewall of this PC has \"" + dropping.front() + "\"",
          "let UDP port " + std::to_string(stream.target.port) + " in"};
    return {
        "rsi", Level::Fault, sends + ", and they do not come through; no rule of a firewall was found",
        "look at what drops them: as root, nft list ruleset, and sysctl net.ipv4.conf.all.rp_filter, by which "
        "Linux drops what comes from a network that it would not answer to"};
  }
  // Others may be controllers of other cells, whose daemons are down.
  const bool ours = drivers::ipv4_of(cell.robot.rsi_peer) == stream.source.address;
  return {"rsi", ours ? Level::Fault : Level::Warning, sends + ", but stream.listen is " + listen,
          "make IP_NUMBER and PORT of the configuration on the controller " + listen + ", or stream.listen " +
              text(stream.target)};
}

const Interface* interface_of(const std::vector<Interface>& interfaces, std::uint32_t address) {
  const auto found = std::ranges::find(interfaces, address, &Interface::address);
  return found == interfaces.end() ? nullptr : &*found;
}

/// Cable and network of the card that listens.
Findings card_findings(const config::CellConfig& cell, const std::vector<Interface>& interfaces) {
  const auto listen = drivers::ipv4_of(cell.stream.listen.host), peer = drivers::ipv4_of(cell.robot.rsi_peer);
  const Interface* card = listen ? interface_of(interfaces, *listen) : nullptr;
  if (!card) return {};
  if (!card->up)
    return {{"rsi", Level::Fault, card->name + ", which has " + cell.stream.listen.host + ", is switched off",
             "switch it on: ip link set " + card->name + " up"}};
  if (!card->running)
    return {{"rsi", Level::Fault, card->name + ", which has " + cell.stream.listen.host + ", has no link",
             "plug in the cable to the controller's RSI network"}};
  if (peer && (*peer & card->mask) != (card->address & card->mask))
    return {{"rsi", Level::Fault,
             "robot.rsi_peer " + cell.robot.rsi_peer + " is not in the network of " + card->name + ", " +
                 network_text(*card),
             "give controller and PC addresses in one RSI network, which is not the controller's other one"}};
  return {};
}

/// Whether the controller is there, and only no program has RSI open.
bool controller_answers(const Observations& seen) {
  return (seen.robot && seen.robot->has_value()) || is_true_at(seen.daemon.status, "/robot/connected");
}

Finding silence_finding(const config::CellConfig& cell, const Observations& seen) {
  const auto* const cycles = find_at(seen.daemon.status, "/stream/cycles");
  const auto came = cycles && cycles->is_number() ? cycles->to_number<std::uint64_t>() : 0;
  std::string finding = "no RSI packet " + std::string{came > 0 ? "comes any more to " : "came to "} +
                        config::text(cell.stream.listen);
  if (came > 0) finding += " (" + std::to_string(came) + " came)";
  if (!seen.rsi.seen && seen.rsi.unclaimed > 0)
    finding += "; " + std::to_string(seen.rsi.unclaimed) +
               " UDP packets came to ports without a program: as root, truepose doctor names them";
  return {"rsi", controller_answers(seen) ? Level::Warning : Level::Fault, finding,
          "start the program on the controller: it must have come to RSI_ON; where the pendant shows "
          "RSITimeout it has, and IP_NUMBER or PORT there, or the controller's RSI network, are others",
          true};
}

bool is_fault(const Finding& finding) { return finding.level == Level::Fault; }

/// Where a cause is found it is said alone: that nothing came follows from it.
Findings nothing_came(const config::CellConfig& cell, const Observations& seen) {
  const auto dropping = dropping_rules(seen.rsi.firewall.value_or(""), cell.stream.listen.port);
  Findings findings = card_findings(cell, seen.interfaces);
  for (const SeenStream& stream : seen.rsi.seen.value_or(std::vector<SeenStream>{}))
    findings.push_back(elsewhere(cell, stream, dropping));
  const bool told_by_daemon = string_at(seen.daemon.status, "/stream/state") == "fault";
  if (told_by_daemon || std::ranges::any_of(findings, is_fault)) return findings;
  findings.insert(findings.begin(), silence_finding(cell, seen));
  for (const std::string& rule : dropping) {
    findings.push_back({"rsi", Level::Warning, "the firewall of this PC has \"" + rule + "\"",
                        "let UDP port " + std::to_string(cell.stream.listen.port) + " in"});
  }
  return findings;
}

/// Whether packets come through: to the daemon, or to us where it does not run.
bool is_heard(const Observations& seen) {
  if (!seen.daemon.unreachable.empty()) return !seen.rsi.senders.empty();
  const auto* age = find_at(seen.daemon.status, "/stream/packet_age_ms");
  const bool fresh =
      age && age->is_number() && age->to_number<double>() < static_cast<double>(daemon::kSilence.count());
  return fresh || !string_at(seen.daemon.status, "/stream/refused").empty();
}

}  // namespace

Findings rsi_findings(const config::CellConfig& cell, const Observations& seen) {
  if (!seen.rsi.not_bound.empty()) return {not_bound(seen)};
  if (!is_heard(seen)) return nothing_came(cell, seen);
  const bool told_by_daemon = string_at(seen.daemon.status, "/stream/refused").contains("are dropped");
  Findings findings;
  for (const RsiSender& sender : seen.rsi.senders) {
    for (Finding& finding : SenderFindings{cell, seen.ethernet, sender, told_by_daemon}.all()) {
      // Of the same packets a daemon that runs names the fault.
      finding.may_follow |= seen.daemon.unreachable.empty();
      findings.push_back(std::move(finding));
    }
  }
  return findings;
}

}  // namespace truepose::tools
