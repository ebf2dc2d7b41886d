#include "tools/truepose/offline/controller_set.hpp"

#include <algorithm>
#include <array>
#include <boost/algorithm/string/replace.hpp>

#include "config/controller_files.hpp"
#include "config/text_file.hpp"
#include "proto/rsi/context.hpp"

namespace truepose::tools {
namespace {

/// What differs between the versions of KUKA System Software; 9 is iiQKA.OS2.
struct KssVersion {
  std::string_view name;
  rsi::ContextFormat context;
};
constexpr std::array<KssVersion, 6> kKssVersions{{{"8.3", rsi::ContextFormat::RsiXml},
                                                  {"8.4", rsi::ContextFormat::RsiXml},
                                                  {"8.5", rsi::ContextFormat::Rsix40},
                                                  {"8.6", rsi::ContextFormat::Rsix},
                                                  {"8.7", rsi::ContextFormat::Rsix},
                                                  {"9", rsi::ContextFormat::Rsix6}}};

const KssVersion& version_of(std::string_view kss) {
  return *std::ranges::find(kKssVersions, kss, &KssVersion::name);
}

std::string shipped(std::string_view name) {
  const auto files = config::controller_files();
  return std::string{std::ranges::find(files, name, &EmbeddedText::name)->text};
}

/// The text between <element> and </element>, which our own files have once.
std::string with_element(std::string text, const std::string& element, const std::string& value) {
  const std::string open = "<" + element + ">";
  const std::size_t begin = text.find(open) + open.size(), end = text.find("</" + element + ">");
  return text.replace(begin, end - begin, value);
}

std::string eki_file(std::string_view name, const config::Endpoint& controller) {
  return with_element(with_element(shipped(name), "IP", controller.host), "PORT",
                      std::to_string(controller.port));
}

/// RSI in the cycle that the daemon expects, and its context by the name that RSI_CREATE knows it by. A
/// program waits for the PC's word half a Timeout longer than RSI.
std::string program_file(std::string text, const config::StreamConfig& stream, const KssVersion& kss) {
  const std::chrono::milliseconds patience{3 * stream.timeout_cycles * stream.cycle / 2};
  boost::replace_all(text, "TP_PATIENCE=50", "TP_PATIENCE=" + std::to_string(patience / kSlowRsiCycle + 1));
  if (stream.cycle == kSlowRsiCycle) {
    boost::replace_all(text, "#IPO_FAST", "#IPO");
    boost::replace_all(text, "TP_CORRECTS_PTP=TRUE", "TP_CORRECTS_PTP=FALSE");
  }
  if (kss.context == rsi::ContextFormat::RsiXml)
    boost::replace_all(text, "RSI_CREATE(\"truepose_rsi\"", "RSI_CREATE(\"truepose_rsi.rsi\"");
  return text;
}

void add_programs(const config::StreamConfig& stream, const KssVersion& kss,
                  std::vector<ControllerFile>& set) {
  for (const EmbeddedText& file : config::controller_files()) {
    if (!file.name.starts_with("kuka/krl/") || file.name.ends_with(".sub")) continue;  // which the cell has
    set.push_back({"Program/" + std::filesystem::path{file.name}.filename().string(), "KRC:\\R1\\Program",
                   program_file(std::string{file.text}, stream, kss)});
  }
}

std::string rsi_ethernet_file(const config::StreamConfig& stream) {
  return with_element(
      with_element(shipped("kuka/rsi/truepose_rsi_ethernet.xml"), "IP_NUMBER", stream.listen.host), "PORT",
      std::to_string(stream.listen.port));
}

std::string context_file(const config::CellConfig& cell, const KssVersion& kss) {
  return context_xml(rsi::truepose_context(demands_of(cell)), kss.context);
}

std::vector<ControllerFile> kss_set(const config::CellConfig& cell, const KssVersion& kss) {
  constexpr const char* kEki = "C:\\KRC\\ROBOTER\\Config\\User\\Common\\EthernetKRL";
  constexpr const char* kRsi = "C:\\KRC\\ROBOTER\\Config\\User\\Common\\SensorInterface";
  std::vector<ControllerFile> set{
      {"EthernetKRL/CellLink.xml", kEki, eki_file("kuka/eki/CellLink.xml", cell.robot.eki_motion)},
      {"EthernetKRL/CellState.xml", kEki, eki_file("kuka/eki/CellState.xml", cell.robot.eki_state)},
      {"SensorInterface/truepose_rsi_ethernet.xml", kRsi, rsi_ethernet_file(cell.stream)},
      {kss.context == rsi::ContextFormat::RsiXml ? "SensorInterface/truepose_rsi.rsi.xml"
                                                 : "SensorInterface/truepose_rsi.rsix",
       kRsi, context_file(cell, kss)}};
  add_programs(cell.stream, kss, set);
  return set;
}

/// What of it iiQKA.OS2 can load: its programs need other calls.
std::vector<ControllerFile> iiqka_set(const config::CellConfig& cell, const KssVersion& kss) {
  const std::string folder = "RobotSensorInterface/", below = "Config/" + folder;
  return {{folder + "truepose_rsi_ethernet.xml", below + "Ethernet configuration",
           rsi_ethernet_file(cell.stream)},
          {folder + "truepose_rsi.rsix", below + "Context", context_file(cell, kss)}};
}

/// A controller needs addresses that it can send to and listen on.
void check_addresses(const config::CellConfig& cell, const std::string& cell_file) {
  const config::Endpoint& listen = cell.stream.listen;
  if (listen.host == "0.0.0.0" || listen.host.starts_with("127.") || listen.port == 0) {
    throw config::ConfigError(cell_file +
                              ": stream.listen: expected this PC's own address on the RSI network, "
                              "which the controller sends to, found " +
                              config::text(listen));
  }
}

}  // namespace

rsi::ContextDemands demands_of(const config::CellConfig& cell) {
  return {.timeout_cycles = cell.stream.timeout_cycles,
          .max_total_deg = cell.stream.max_total_deg,
          .cycle_ms = std::chrono::duration<double, std::milli>(cell.stream.cycle).count()};
}

std::vector<std::string_view> kss_names() {
  std::vector<std::string_view> names;
  for (const KssVersion& version : kKssVersions) names.push_back(version.name);
  return names;
}

bool is_iiqka(std::string_view kss) { return version_of(kss).context == rsi::ContextFormat::Rsix6; }

std::vector<ControllerFile> controller_files_of(const config::CellConfig& cell, const std::string& cell_file,
                                                std::string_view kss) {
  check_addresses(cell, cell_file);
  return is_iiqka(kss) ? iiqka_set(cell, version_of(kss)) : kss_set(cell, version_of(kss));
}

}  // namespace truepose::tools
