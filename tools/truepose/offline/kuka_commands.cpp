#include <algorithm>
#include <array>
#include <boost/algorithm/string/replace.hpp>
#include <chrono>
#include <cstdio>
#include <memory>
#include <set>
#include <utility>

#include "config/cell_config.hpp"
#include "config/controller_files.hpp"
#include "config/text_file.hpp"
#include "core/formatted.hpp"
#include "proto/rsi/context.hpp"
#include "proto/rsi/lint_kinds.hpp"
#include "tools/truepose/offline/offline_commands.hpp"

namespace truepose::tools {
namespace {

using config::ConfigError;

rsi::ContextDemands demands_of(const config::CellConfig& cell) {
  return {.timeout_cycles = cell.stream.timeout_cycles,
          .max_total_deg = cell.stream.max_total_deg,
          .cycle_ms = std::chrono::duration<double, std::milli>(cell.stream.cycle).count()};
}

// ---- kuka write ----

constexpr std::chrono::milliseconds kKrlCycle{12};  // of the interpreter, and of RSI in #IPO

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

std::vector<std::string_view> kss_names() {
  std::vector<std::string_view> names;
  for (const KssVersion& version : kKssVersions) names.push_back(version.name);
  return names;
}

struct KukaWrite {
  std::string cell_file, kss = "8.6";
  std::filesystem::path folder;
};

/// A file of the controller: where it goes below the folder of the set, and there.
struct ControllerFile {
  std::string name;         ///< "EthernetKRL/CellLink.xml"
  std::string destination;  ///< on the controller
  std::string text;
};

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
  boost::replace_all(text, "TP_PATIENCE=50", "TP_PATIENCE=" + std::to_string(patience / kKrlCycle + 1));
  if (stream.cycle == kKrlCycle) {
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

std::vector<ControllerFile> controller_set(const config::CellConfig& cell, const KssVersion& kss) {
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
void check_addresses(const KukaWrite& command, const config::CellConfig& cell) {
  const config::Endpoint& listen = cell.stream.listen;
  if (listen.host == "0.0.0.0" || listen.host.starts_with("127.") || listen.port == 0) {
    throw ConfigError(command.cell_file +
                      ": stream.listen: expected this PC's own address on the RSI network, "
                      "which the controller sends to, found " +
                      config::text(listen));
  }
}

int run_write(const KukaWrite& command) {
  const config::CellConfig cell = config::load_cell(command.cell_file);
  check_addresses(command, cell);
  const KssVersion& kss = *std::ranges::find(kKssVersions, command.kss, &KssVersion::name);
  const bool iiqka = kss.context == rsi::ContextFormat::Rsix6;
  const std::vector<ControllerFile> set = iiqka ? iiqka_set(cell, kss) : controller_set(cell, kss);
  for (const ControllerFile& file : set) {
    const std::filesystem::path path = command.folder / file.name;
    std::error_code failed;
    std::filesystem::create_directories(path.parent_path(), failed);
    config::write_text_file(path, file.text);  // says why, where the folder could not be made
    std::printf("%-44s to %s\n", file.name.c_str(), file.destination.c_str());
  }
  std::printf(
      "\n%s\n",
      iiqka ? "Missing: the programs. RSI 6 and EKI 6 have other calls (RSI_LOAD, RSI_PROCESS_ON, EKI_Load, "
              "EKI_ReadNext), and no set of ours uses them: docs/kuka.md."
            : "In KRC:\\R1\\System\\sps.sub: TP_SUBMIT_INIT() in the fold USER INIT, "
              "TP_SUBMIT_CYCLE() in the fold USER PLC.");
  if (!iiqka && cell.stream.cycle == kKrlCycle)
    std::printf(
        "At 12 ms (#IPO) RSI corrects LIN and CIRC alone: TP_BEGIN() refuses. Set stream.cycle_ms 4 for "
        "production programs.\n");
  std::printf(
      "For KSS %s, %s. Not run on hardware yet: read docs/kuka.md, and try everything in "
      "T1 at low override first.\n",
      command.kss.c_str(), cell.name.c_str());
  return kDone;
}

// ---- kuka lint ----

struct KukaLint {
  std::vector<std::string> files;
  std::string cell_file;
};

/// What was given, by kind.
struct Given {
  std::string ethernet_file, context_file;
  std::optional<rsi::EthernetConfig> ethernet;
  std::optional<rsi::Context> context;
};

void take_ethernet(Given& given, const std::string& file, const std::string& text) {
  auto ethernet = rsi::parse_ethernet_config(text);
  if (!ethernet) throw ConfigError(file + ": " + ethernet.error());
  given.ethernet = *std::move(ethernet);
  given.ethernet_file = file;
}

Given read_files(const std::vector<std::string>& files) {
  Given given;
  for (const std::string& file : files) {
    const std::string text = config::read_text_file(file);
    if (text.contains("<CONFIG>")) {
      take_ethernet(given, file, text);
      continue;
    }
    auto context = rsi::parse_context(text);
    if (!context) throw ConfigError(file + ": " + context.error());
    given.context = *std::move(context);
    given.context_file = file;
  }
  return given;
}

/// @return whether nothing was found
bool tell(AnswerText& answer, const std::string& file, const std::vector<Message>& findings) {
  for (const Message& finding : findings) std::printf("%s: %s\n", file.c_str(), answer.add(finding).c_str());
  if (findings.empty()) std::printf("%s: good\n", file.c_str());
  return findings.empty();
}

int run_lint(const KukaLint& command) {
  Given given = read_files(command.files);
  rsi::ContextDemands demands;
  std::vector<Message> of_ethernet;
  if (!command.cell_file.empty()) {
    const config::CellConfig cell = config::load_cell(command.cell_file);
    demands = demands_of(cell);
    if (!given.ethernet) {
      const std::string file = cell.stream.ethernet_xml.string();
      take_ethernet(given, file, config::read_text_file(file));
    }
    if (given.ethernet->address != cell.stream.listen.host ||
        given.ethernet->port != cell.stream.listen.port) {
      of_ethernet.push_back(message<rsi::LintKind::Address>(given.ethernet->address, given.ethernet->port,
                                                            config::text(cell.stream.listen)));
    }
  }
  if (!given.ethernet) throw bad_usage("give the RSI ethernet configuration too, or --cell, which names it");
  demands.ethernet_file = std::filesystem::path{given.ethernet_file}.filename();
  std::ranges::move(rsi::lint(*given.ethernet), std::back_inserter(of_ethernet));
  AnswerText answer;
  bool good = tell(answer, given.ethernet_file, of_ethernet);
  if (given.context)
    good &= tell(answer, given.context_file, rsi::lint(*given.context, *given.ethernet, demands));
  return good ? kDone : kFailed;
}

}  // namespace

Command kuka_commands() {
  return {.name = "kuka", .help = "What the KUKA controller loads", .task = Task::Cell};
}

Command kuka_write_command() {
  const auto command = std::make_shared<KukaWrite>();
  KukaWrite& c = *command;
  return {.name = "kuka write",
          .help = "Writes the controller's files with this cell's addresses, limits and cycle",
          .options = {Option("--cell", &c.cell_file, "Cell file",
                             {.required = true, .place = "CELL", .file = FileUse::Read}),
                      Option("--kss", &c.kss, "Version of the controller's software",
                             {.shows_default = true, .check = available(kss_names())}),
                      Option("--out", &c.folder, "Folder for them", {.required = true, .type = "DIR"})},
          .run = [command] { return run_write(*command); },
          .examples = {{"kuka write cell.yaml --kss 8.6 -o controller"}}};
}

Command kuka_lint_command() {
  const auto command = std::make_shared<KukaLint>();
  KukaLint& c = *command;
  return {
      .name = "kuka lint",
      .help = "Says what in a controller's RSI files would keep corrections from the axes",
      .options = {Option("files", &c.files,
                         "RSI ethernet configuration and context (.rsix, .rsi.xml), in any order",
                         {.required = true, .type = "FILE..", .file = FileUse::Read}),
                  Option("--cell", &c.cell_file, "Cell file: its bounds and addresses must agree with them",
                         {.file = FileUse::Read})},
      .run = [command] { return run_lint(*command); },
      .examples = {{"kuka lint truepose_ethernet.xml truepose.rsix"},
                   {"kuka lint truepose.rsix --cell cell.yaml"}}};
}

}  // namespace truepose::tools
