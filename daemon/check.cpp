#include "daemon/check.hpp"

#include <unistd.h>

#include <algorithm>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/address.hpp>
#include <boost/asio/ip/udp.hpp>
#include <chrono>
#include <filesystem>
#include <iterator>
#include <optional>
#include <thread>

#include "config/air_file.hpp"
#include "config/cell_setup.hpp"
#include "daemon/control/access_list.hpp"
#include "daemon/control/control_server.hpp"
#include "daemon/control/tls_identity.hpp"
#include "daemon/realtime/stream_cycle.hpp"
#include "daemon/realtime/stream_options.hpp"
#include "daemon/recorder/folder_access.hpp"
#include "daemon/recorder/recording_folder.hpp"
#include "daemon/store/store.hpp"
#include "daemon/web/web_server.hpp"
#include "drivers/kuka/scheduling.hpp"
#include "proto/control/json_text.hpp"
#include "proto/rsi/lint_kinds.hpp"

namespace truepose::daemon {

namespace {

namespace fs = std::filesystem;
namespace ip = boost::asio::ip;
using Level = CheckFinding::Level;

constexpr std::chrono::milliseconds kFastCycle{4}, kSlowCycle{12};

void append(std::vector<CheckFinding>& findings, std::vector<CheckFinding> more) {
  std::ranges::move(more, std::back_inserter(findings));
}

std::optional<ip::address_v4> ipv4(const std::string& text) {
  boost::system::error_code error;
  const ip::address_v4 address = ip::make_address_v4(text, error);
  return error ? std::nullopt : std::optional{address};
}

/// Whether a socket can have the address: all of 127.0.0.0/8 counts, which no list of network cards shows.
bool is_of_this_machine(const ip::address_v4& address) {
  boost::asio::io_context context;
  ip::udp::socket socket{context, ip::udp::v4()};
  boost::system::error_code error;
  socket.bind({address, 0}, error);
  return !error;
}

/// Whether the controller's datagrams and the daemon's socket meet: compares IP_NUMBER and PORT of its
/// configuration with stream.listen and this machine's addresses.
std::vector<CheckFinding> check_stream_address(const config::StreamConfig& stream,
                                               const rsi::EthernetConfig& ethernet) {
  const std::string file = stream.ethernet_xml.string();
  const auto target = ipv4(ethernet.address);
  if (!target || target->is_unspecified()) {
    return {{Level::Failure, file + ": CONFIG/IP_NUMBER is \"" + ethernet.address +
                                 "\", expected the IPv4 address of this PC in the RSI network"}};
  }
  const auto listen = ipv4(stream.listen.host);
  if (!listen) {
    return {{Level::Failure, "stream.listen: \"" + stream.listen.host +
                                 "\" is not an IPv4 address: give that of this PC in the RSI network"}};
  }
  std::vector<CheckFinding> findings;
  const auto warn = [&findings](std::string text) { findings.push_back({Level::Warning, std::move(text)}); };
  const bool same_port = stream.listen.port == 0 || stream.listen.port == ethernet.port;
  const bool same_address = listen->is_unspecified() || *listen == *target;
  if (!same_port || !same_address)
    warn(file + ": " +
         sentences(
             message<rsi::LintKind::Address>(ethernet.address, ethernet.port, config::text(stream.listen))));
  if (!is_of_this_machine(*listen)) {
    warn("stream.listen: this machine does not have the address " + stream.listen.host +
         " now: the daemon cannot start before its network card has it");
  }
  if (listen->is_unspecified() && !is_of_this_machine(*target))
    warn("the controller sends to " + ethernet.address + ":" + std::to_string(ethernet.port) +
         " (IP_NUMBER and PORT of " + file + "), but this machine does not have that address now");
  return findings;
}

CheckFinding check_certificate(const config::TlsConfig& tls, std::chrono::system_clock::time_point now) {
  const auto identity = TlsIdentity::load(tls);
  if (!identity) return {Level::Failure, identity.error()};
  const std::string file = tls.certificate.string() + ": the daemon's certificate ";
  const std::string fault = control::validity_fault(identity->certificate(), now);
  if (!fault.empty()) {
    return {Level::Failure,
            file + fault + ", and the clock of this PC says " + control::rfc3339(now) +
                ": set it right, or make a new certificate (`truepose tls init`)",
            true};
  }
  return {Level::Good, file + "holds until " + control::rfc3339(identity->certificate().until)};
}

/// Where the control port may be.
std::vector<CheckFinding> check_control_address(const config::ControlConfig& control,
                                                std::chrono::system_clock::time_point now) {
  const auto address = control_address(control.listen);
  if (!address) return {{Level::Failure, address.error()}};
  if (!control.tls) return {};
  const auto for_others = tls_address(control.tls->listen);
  if (!for_others) return {{Level::Failure, for_others.error()}};
  return {check_certificate(*control.tls, now)};
}

std::vector<CheckFinding> check_web_address(const config::CellConfig& config) {
  if (!config.web || !config.web->listen) return {};
  const auto address = web_address(*config.web->listen, config.control.tls.has_value());
  if (!address) return {{Level::Failure, address.error()}};
  return {};
}

/// That no two keys of the cell file name one port of one host.
std::vector<CheckFinding> check_ports(const config::CellConfig& config) {
  struct Named {
    const char* key;
    config::Endpoint endpoint;
  };
  // RSI is UDP: its port is another one, whatever its number.
  std::vector<Named> all{{"robot.eki_motion", config.robot.eki_motion},
                         {"robot.eki_state", config.robot.eki_state},
                         {"tracker.address", config.tracker.address},
                         {"control.listen", config.control.listen}};
  if (config.control.tls) all.push_back({"control.tls.listen", config.control.tls->listen});
  if (config.web && config.web->listen) all.push_back({"web.listen", *config.web->listen});
  for (Named& named : all) {
    if (named.endpoint.host == "localhost") named.endpoint.host = "127.0.0.1";
  }
  std::vector<CheckFinding> findings;
  for (auto one = all.begin(); one != all.end(); ++one) {
    for (auto other = std::next(one); other != all.end(); ++other) {
      if (one->endpoint.port == 0 || config::text(one->endpoint) != config::text(other->endpoint)) continue;
      findings.push_back({Level::Failure, std::string{one->key} + " and " + other->key + " are both " +
                                              config::text(one->endpoint) +
                                              ": each needs a port of its own"});
    }
  }
  return findings;
}

/// Tried in a thread that ends with the trial.
std::vector<CheckFinding> check_cpu(int cpu) {
  if (cpu < 0) return {};
  std::optional<std::string> why_not;
  std::thread{[&] { why_not = drivers::pin_to(cpu); }}.join();
  if (!why_not) return {};
  return {{Level::Failure, *why_not}};
}

void check_stream(const config::CellConfig& config, std::vector<CheckFinding>& findings) {
  if (const auto why = why_unfit(config.robot.model)) {
    findings.push_back({Level::Failure, config.robot.file.string() + ": " + *why});
    return;
  }
  const std::string file = config.stream.ethernet_xml.string();
  const auto ethernet = read_ethernet(config.stream.ethernet_xml);
  if (!ethernet) {
    findings.push_back({Level::Failure, ethernet.error()});
    return;
  }
  const auto stream = StreamCycle::create(config.robot.model, *ethernet, StreamOptions::of(config));
  if (!stream) {
    findings.push_back({Level::Failure, file + ": " + stream.error()});
    return;
  }
  findings.push_back({Level::Good, file + ": the controller sends to " + ethernet->address + ":" +
                                       std::to_string(ethernet->port) + " and takes " +
                                       *ethernet->axis_correction + " as " + ethernet->sentype});
  for (const Message& found : rsi::lint(*ethernet))
    findings.push_back({Level::Warning, file + ": " + sentences(found)});
  append(findings, check_stream_address(config.stream, *ethernet));
  append(findings, check_cpu(config.stream.cpu));
  const auto cycle = config.stream.cycle;
  if (cycle != kFastCycle && cycle != kSlowCycle) {
    findings.push_back({Level::Warning, "stream.cycle_ms is " + std::to_string(cycle.count()) +
                                            ", but controllers send every 4 ms (IPO_FAST) or 12 ms (IPO)"});
  }
}

std::vector<CheckFinding> check_poses(const config::CellConfig& config) {
  const auto why = config::too_few_poses(config);
  if (!why) return {};
  return {{Level::Failure, "campaign.identify_poses: " + *why}};
}

std::vector<CheckFinding> check_air(const config::TrackerConfig& tracker) {
  const auto source = config::air_source(tracker);
  if (!source) return {};
  const auto air = source();
  if (air) return {};
  return {{Level::Failure, "tracker.air_file: " + air.error()}};
}

CheckFinding check_token(const fs::path& file) {
  const auto token = read_token(file);
  if (!token) return {Level::Failure, token.error()};
  return {Level::Good, file.string() + ": a token that only its owner can read"};
}

CheckFinding check_access(const fs::path& file) {
  const auto access = read_access_file(file);
  if (!access) return {Level::Failure, access.error()};
  return {Level::Good,
          file.string() + ": " + std::to_string(access->entries.size()) + " may use the control port"};
}

CheckFinding check_store(const fs::path& file) {
  const fs::path folder = fs::absolute(file).parent_path();
  std::error_code none;
  if (!fs::exists(folder, none) && !none)
    return {Level::Failure, file.string() + ": there is no folder " + folder.string() + "; make it"};
  if (const std::string why = why_not_writable(folder); !why.empty())
    return {Level::Failure, folder.string() + ": the store's folder cannot be written: " + why +
                                "; give `store` a folder that can be (a service: /var/lib/truepose/CELL)"};
  if (!fs::exists(file, none)) return {Level::Good, file.string() + ": will be made"};
  if (fs::is_empty(file, none))
    return {Level::Warning, file.string() +
                                ": is empty, and is taken as a new store; if there was one, stop the "
                                "daemon and restore a backup (truepose restore)"};
  if (!fs::is_regular_file(file, none) || ::access(file.c_str(), R_OK | W_OK) != 0)
    return {Level::Failure, file.string() + ": is no file that this user can read and write"};
  const StoreResult<void> known = Store::examine(file);
  if (!known) return {Level::Failure, known.error().detail};
  return {Level::Good, file.string() + ": can be written"};
}

/// Without its folder the daemon records all the same, in memory; and writes no recording.
std::vector<CheckFinding> check_recording(const config::RecordingConfig& recording) {
  const std::string why = RecordingFolder{recording}.why_unusable();
  if (why.empty()) return {};
  return {{Level::Warning, why + ", or faults leave no recording"}};
}

}  // namespace

std::vector<CheckFinding> check(const config::CellConfig& config, std::chrono::system_clock::time_point now) {
  std::vector<CheckFinding> findings;
  check_stream(config, findings);
  append(findings, check_control_address(config.control, now));
  append(findings, check_web_address(config));
  append(findings, check_ports(config));
  append(findings, check_poses(config));
  append(findings, check_air(config.tracker));
  findings.push_back(check_token(config.control.token_file));
  findings.push_back(check_access(access_file_of(config.store)));
  findings.push_back(check_store(config.store));
  append(findings, check_recording(config.recording));
  return findings;
}

}  // namespace truepose::daemon
