#include <algorithm>
#include <chrono>
#include <cstdio>
#include <memory>
#include <set>
#include <utility>

#include "config/cell_config.hpp"
#include "config/text_file.hpp"
#include "core/formatted.hpp"
#include "proto/rsi/context.hpp"
#include "proto/rsi/lint_kinds.hpp"
#include "tools/truepose/offline/controller_set.hpp"
#include "tools/truepose/offline/offline_commands.hpp"

namespace truepose::tools {
namespace {

using config::ConfigError;

// ---- kuka write ----

struct KukaWrite {
  std::string cell_file, kss = "8.6";
  std::filesystem::path folder;
};

int run_write(const KukaWrite& command) {
  const config::CellConfig cell = config::load_cell(command.cell_file);
  const std::vector<ControllerFile> set = controller_files_of(cell, command.cell_file, command.kss);
  const bool iiqka = is_iiqka(command.kss);
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
  if (!iiqka && cell.stream.cycle == kSlowRsiCycle)
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
