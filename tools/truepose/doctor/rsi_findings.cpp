#include <algorithm>
#include <chrono>
#include <cmath>
#include <iterator>

#include "core/formatted.hpp"
#include "core/math/units.hpp"
#include "daemon/realtime/stream_checks.hpp"
#include "daemon/realtime/stream_options.hpp"
#include "proto/rsi/lint_kinds.hpp"
#include "tools/truepose/doctor/diagnose.hpp"
#include "tools/truepose/doctor/network.hpp"

namespace truepose::tools {

namespace {

using Kind = FindingKind;

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

/// The findings about one sender.
class SenderFindings {
 public:
  /// @param reported_by_daemon  that packets of another sender are dropped
  SenderFindings(const config::CellConfig& cell, const std::optional<rsi::EthernetConfig>& ethernet,
                 const RsiSender& sender, bool reported_by_daemon)
      : cell_{cell},
        ethernet_{ethernet},
        sender_{sender},
        reported_by_daemon_{reported_by_daemon},
        from_{text(sender.source)} {}

  Findings all() {
    check_address();
    if (is_another_) return findings_;  // what it sends is not the controller's
    check_cycle();
    check_malformed();
    if (sender_.frames == 0) return findings_;
    check_names();
    check_decimals();
    check_arm_condition();
    check_limits();
    check_losses();
    if (findings_.empty())
      findings_.push_back(
          good("rsi", from_ + formatted(" sends good frames every %.2f ms", sender_.cycle_ms().value_or(0))));
    return findings_;
  }

 private:
  template <Kind kKind, typename... Values>
  void say(Level level, const Values&... values) {
    findings_.push_back(finding<kKind>("rsi", level, values...));
  }

  void check_address() {
    const auto peer = drivers::ipv4_of(cell_.robot.rsi_peer);
    if (!peer || *peer == sender_.source.address) return;
    is_another_ = true;
    if (!reported_by_daemon_) say<Kind::Sender>(Level::Fault, from_, cell_.robot.rsi_peer);
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
  void check_cycle() {
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
    const std::string every = measured_ms ? formatted(" every %.2f ms", *measured_ms) : "";
    const auto say_cycle = [&]<Kind kKind>(const char* or_start = "") {
      say<kKind>(Level::Fault, from_, every, sender_.ipoc_step, configured_ms, *ipoc_ms, or_start);
    };
    if (is_off && *ipoc_ms == configured_ms) return say_cycle.operator()<Kind::CycleOfSender>();
    if (is_off) return say_cycle.operator()<Kind::CycleAndIpoc>();
    say_cycle.operator()<Kind::Cycle>(configured_ms == kFastCycle_ms  ? ", or start RSI with #IPO_FAST"
                                      : configured_ms == kIpoCycle_ms ? ", or start RSI with #IPO"
                                                                      : "");
  }

  void check_malformed() {
    if (sender_.malformed == 0) return;
    say<Kind::Malformed>(sender_.frames == 0 ? Level::Fault : Level::Warning,
                         cell_.stream.ethernet_xml.string(), from_, sender_.malformed, sender_.why_malformed);
  }

  void check_names() {
    if (!ethernet_) return;
    const rsi::NameDifference names = compare_names(sender_.elements, *ethernet_);
    if (names == rsi::NameDifference{}) return;
    std::string differing;
    if (!names.unknown.empty()) differing += "; not in it: " + listed(names.unknown);
    if (!names.missing.empty()) differing += "; not sent: " + listed(names.missing);
    say<Kind::Elements>(names.missing.empty() ? Level::Warning : Level::Fault,
                        cell_.stream.ethernet_xml.string(), from_, differing);
  }

  void check_decimals() {
    const int decimals = sender_.elements.decimals;
    if (decimals >= rsi::kLeastPrecision) return;
    Message rounded = message<rsi::LintKind::Precision>(static_cast<double>(decimals),
                                                        std::pow(10, -decimals), rsi::kLeastPrecision);
    rounded.what = from_ + ": " + rounded.what;
    findings_.push_back({"rsi", Level::Warning, std::move(rounded)});
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
  void check_arm_condition() {
    const double rounded_mm = sender_.elements.decimals < rsi::kLeastPrecision ? rounding_mm() : 0;
    daemon::ArmCheck check{cell_.robot.model, cell_.stream.cycle,
                           cell_.robot.max_fk_deviation_mm + rounded_mm};
    if (const auto found = check.arm(sender_.frame, 0))
      findings_.push_back(from_sentence("rsi", Level::Fault,
                                        daemon::reason({.fault = found->fault, .detail = found->detail})));
  }

  void check_limits() {
    const auto& axes = sender_.frame.aipos_rad;
    const auto& joints = cell_.robot.model.joints;
    if (!axes) return;
    for (std::size_t i = 0; i < std::min(axes->size(), joints.size()); ++i) {
      const double q = (*axes)[i];
      if (q >= joints[i].min && q <= joints[i].max) continue;
      say<Kind::AxisLimit>(Level::Warning, i + 1, q * kDegPerRad, joints[i].min * kDegPerRad,
                           joints[i].max * kDegPerRad);
    }
  }

  void check_losses() {
    if (sender_.ipoc_step == 0) return;
    const auto cycles = static_cast<double>((sender_.ipoc - sender_.ipoc_begin) / sender_.ipoc_step + 1);
    const double lost = 1 - static_cast<double>(sender_.frames) / cycles;
    if (lost < kLost) return;
    say<Kind::Losses>(Level::Warning, 100 * lost, from_);
    findings_.back().may_follow = true;
  }

  const config::CellConfig& cell_;
  const std::optional<rsi::EthernetConfig>& ethernet_;
  const RsiSender& sender_;
  bool reported_by_daemon_;
  bool is_another_ = false;  // than the controller
  std::string from_;
  Findings findings_;
};

// ---- Nothing could come ----

Finding not_bound(const Observations& seen) {
  if (seen.rsi.taken) return finding<Kind::PortTaken>("rsi", Level::Fault, seen.rsi.not_bound);
  return finding<Kind::Listen>("rsi", Level::Fault, seen.rsi.not_bound, addresses_text(seen.interfaces));
}

// ---- Nothing came ----

/// @param dropping  the firewall's rules that may drop what comes to the port
Finding elsewhere(const config::CellConfig& cell, const SeenStream& stream,
                  const std::vector<std::string>& dropping) {
  const std::string listen = config::text(cell.stream.listen);
  const std::string source = text(stream.source), target = text(stream.target);
  const bool address = drivers::ipv4_of(cell.stream.listen.host) == stream.target.address ||
                       cell.stream.listen.host == "0.0.0.0";
  if (address && stream.target.port == cell.stream.listen.port) {
    if (dropping.empty()) return finding<Kind::Dropped>("rsi", Level::Fault, source, target);
    return finding<Kind::Firewall>("rsi", Level::Fault, source + " sends RSI packets to " + target + ", and ",
                                   dropping.front(), stream.target.port);
  }
  // Others may be controllers of other cells, whose daemons are down.
  const bool ours = drivers::ipv4_of(cell.robot.rsi_peer) == stream.source.address;
  return finding<Kind::Target>("rsi", ours ? Level::Fault : Level::Warning, source, target, listen);
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
  const std::string& address = cell.stream.listen.host;
  if (!card->up) return {finding<Kind::CardOff>("rsi", Level::Fault, card->name, address)};
  if (!card->running) return {finding<Kind::NoLink>("rsi", Level::Fault, card->name, address)};
  if (peer && (*peer & card->mask) != (card->address & card->mask))
    return {
        finding<Kind::Network>("rsi", Level::Fault, cell.robot.rsi_peer, card->name, network_text(*card))};
  return {};
}

/// Whether the controller is there, and only no program has RSI open.
bool controller_answers(const Observations& seen) {
  return (seen.robot && seen.robot->has_value()) || seen.daemon.status.robot.connected;
}

Finding silence_finding(const config::CellConfig& cell, const Observations& seen) {
  std::string others;
  if (!seen.rsi.seen && seen.rsi.unclaimed > 0)
    others = "; " + std::to_string(seen.rsi.unclaimed) +
             " UDP packets came to ports without a program: as root, truepose doctor names them";
  Finding silent =
      finding<Kind::NoPacket>("rsi", controller_answers(seen) ? Level::Warning : Level::Fault,
                              config::text(cell.stream.listen), seen.daemon.status.stream.cycles, others);
  silent.may_follow = true;
  return silent;
}

bool is_fault(const Finding& one) { return one.level == Level::Fault; }

/// Where a cause is found it is said alone: that nothing came follows from it.
Findings no_packet_findings(const config::CellConfig& cell, const Observations& seen) {
  const auto dropping = dropping_rules(seen.rsi.firewall.value_or(""), cell.stream.listen.port);
  Findings findings = card_findings(cell, seen.interfaces);
  for (const SeenStream& stream : seen.rsi.seen.value_or(std::vector<SeenStream>{}))
    findings.push_back(elsewhere(cell, stream, dropping));
  const bool reported_by_daemon = seen.daemon.status.stream.state == "fault";
  if (reported_by_daemon || std::ranges::any_of(findings, is_fault)) return findings;
  findings.insert(findings.begin(), silence_finding(cell, seen));
  for (const std::string& rule : dropping)
    findings.push_back(finding<Kind::Firewall>("rsi", Level::Warning, "", rule, cell.stream.listen.port));
  return findings;
}

/// Whether packets come through: to the daemon, or to us where it does not run.
bool has_packets(const Observations& seen) {
  if (!seen.daemon.unreachable.empty()) return !seen.rsi.senders.empty();
  const rpc::StreamStatus& stream = seen.daemon.status.stream;
  const bool fresh = stream.packet_age_ms && *stream.packet_age_ms < daemon::kSilence.count();
  return fresh || stream.refused;
}

}  // namespace

Findings rsi_findings(const config::CellConfig& cell, const Observations& seen) {
  if (!seen.rsi.not_bound.empty()) return {not_bound(seen)};
  if (!has_packets(seen)) return no_packet_findings(cell, seen);
  const bool reported_by_daemon = seen.daemon.status.stream.refused.value_or("").contains("are dropped");
  Findings findings;
  for (const RsiSender& sender : seen.rsi.senders) {
    for (Finding& one : SenderFindings{cell, seen.ethernet, sender, reported_by_daemon}.all()) {
      // Of the same packets a daemon that runs names the fault.
      one.may_follow |= seen.daemon.unreachable.empty();
      findings.push_back(std::move(one));
    }
  }
  return findings;
}

}  // namespace truepose::tools
