#include "daemon/check.hpp"

#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <iterator>

#include "config/cell_setup.hpp"
#include "daemon/address_check.hpp"
#include "daemon/control/token_file.hpp"
#include "daemon/ethernet_file.hpp"
#include "daemon/realtime/stream_cycle.hpp"
#include "daemon/store/store.hpp"

namespace truepose::daemon {

namespace {

namespace fs = std::filesystem;
using Level = Finding::Level;

constexpr std::chrono::milliseconds kFastCycle{4}, kSlowCycle{12};

void append(std::vector<Finding>& findings, std::vector<Finding> more) {
  std::ranges::move(more, std::back_inserter(findings));
}

void check_stream(const config::CellConfig& config, std::vector<Finding>& findings) {
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
  for (const std::string& sentence : rsi::lint(*ethernet))
    findings.push_back({Level::Warning, file + ": " + sentence});
  append(findings, check_stream_address(config.stream, *ethernet));
  const auto cycle = config.stream.cycle;
  if (cycle != kFastCycle && cycle != kSlowCycle) {
    findings.push_back({Level::Warning, "stream.cycle_ms is " + std::to_string(cycle.count()) +
                                            ", but controllers send every 4 ms (IPO_FAST) or 12 ms (IPO)"});
  }
}

std::vector<Finding> check_poses(const config::CellConfig& config) {
  const auto why = config::too_few_poses(config);
  if (!why) return {};
  return {{Level::Failure, "campaign.identify_poses: " + *why}};
}

Finding check_token(const fs::path& file) {
  const auto token = read_token(file);
  if (!token) return {Level::Failure, token.error()};
  return {Level::Good, file.string() + ": a token that only its owner can read"};
}

Finding check_store(const fs::path& file) {
  const fs::path folder = fs::absolute(file).parent_path();
  std::error_code none;
  if (!fs::is_directory(folder, none))
    return {Level::Failure, file.string() + ": there is no folder " + folder.string() + "; make it"};
  if (::access(folder.c_str(), W_OK | X_OK) != 0)
    return {Level::Failure, folder.string() + ": the store's folder cannot be written by this user"};
  if (!fs::exists(file, none)) return {Level::Good, file.string() + ": will be made"};
  if (!fs::is_regular_file(file, none) || ::access(file.c_str(), R_OK | W_OK) != 0)
    return {Level::Failure, file.string() + ": is no file that this user can read and write"};
  const StoreResult<void> known = Store::examine(file);
  if (!known) return {Level::Failure, known.error().detail};
  return {Level::Good, file.string() + ": can be written"};
}

}  // namespace

std::vector<Finding> check(const config::CellConfig& config) {
  std::vector<Finding> findings;
  check_stream(config, findings);
  append(findings, check_control_address(config.control));
  append(findings, check_ports(config));
  append(findings, check_poses(config));
  findings.push_back(check_token(config.control.token_file));
  findings.push_back(check_store(config.store));
  return findings;
}

}  // namespace truepose::daemon
