#include "tools/sim/controller/controller_setup.hpp"

#include <algorithm>
#include <filesystem>
#include <iterator>
#include <utility>
#include <vector>

#include "config/controller_files.hpp"
#include "config/kuka_archive.hpp"
#include "config/text_file.hpp"
#include "core/formatted.hpp"
#include "proto/krl/lexer.hpp"
#include "tools/sim/controller/rsi_flow.hpp"
#include "tools/sim/system_files.hpp"

namespace truepose::sim {
namespace {

namespace fs = std::filesystem;

const std::string kContext = "truepose_rsi";

/// What the controller loads, by path: "kuka/krl/truepose_motion.src" and the like.
std::map<std::string, std::string> files_of(const config::Scenario& scenario) {
  std::map<std::string, std::string> files;
  if (scenario.controller_files.empty()) {
    for (const EmbeddedText& file : config::controller_files()) files.emplace(file.name, file.text);
    return files;
  }
  if (!fs::is_directory(scenario.controller_files))
    throw config::ConfigError{scenario.controller_files.string() + ": is no folder"};
  for (const auto& entry : fs::recursive_directory_iterator{scenario.controller_files}) {
    if (entry.is_regular_file()) files.emplace(entry.path(), config::read_text_file(entry.path()));
  }
  return files;
}

bool is_krl(const fs::path& file) {
  return file.extension() == ".src" || file.extension() == ".sub" || file.extension() == ".dat";
}

std::string module_file(const krl::Source& source) {
  return truepose::krl::in_capitals(fs::path{source.file}.filename().string());
}

/// The controller's programs: those of `more` take the place of others of the same name.
void replace_with(std::vector<krl::Source>& programs, std::vector<krl::Source> more) {
  for (const krl::Source& source : more)
    std::erase_if(programs,
                  [&](const krl::Source& other) { return module_file(other) == module_file(source); });
  std::ranges::move(more, std::back_inserter(programs));
}

bool calls_state_server(const std::string& text) {
  return truepose::krl::in_capitals(text).find("TP_SUBMIT_CYCLE") != std::string::npos;
}

/// Without the state server no client sees the controller: an sps.sub that does not call it is not taken.
std::vector<krl::Source> archive_programs(const fs::path& archive) {
  std::vector<krl::Source> programs;
  for (config::ArchiveFile& file : config::read_kuka_archive(archive)) {
    krl::Source source{.file = std::move(file.path), .text = std::move(file.text), .is_partial = true};
    if (module_file(source) == "SPS.SUB" && !calls_state_server(source.text)) continue;
    programs.push_back(std::move(source));
  }
  return programs;
}

/// Where the arm stands at first: in the middle of its ranges, or where the path begins that it is led along.
JointVector home(const config::Scenario& scenario) {
  if (!scenario.stream_path.empty()) return scenario.stream_path.front();
  JointVector q(scenario.nominal.joint_count());
  for (Eigen::Index i = 0; i < q.size(); ++i) {
    const Joint& joint = scenario.nominal.joints[static_cast<std::size_t>(i)];
    q[i] = (joint.min + joint.max) / 2;
  }
  return q;
}

/// In place of the sps.sub that each controller has.
krl::Source idle_submit() {
  return {.file = "sps.sub", .text = "DEF SPS()\nLOOP\nWAIT SEC 0.012\nENDLOOP\nEND\n"};
}

/// The names under which a context's file is found: RSI 3 has it with ".rsi".
std::vector<std::string> context_names(const std::string& file) {
  constexpr std::string_view kRsix = ".rsix", kXml = ".xml", kRsi = ".rsi";
  if (file.ends_with(kRsix)) return {file.substr(0, file.size() - kRsix.size())};
  if (!file.ends_with(std::string{kRsi} + std::string{kXml})) return {};
  const std::string name = file.substr(0, file.size() - kXml.size());
  return {name, name.substr(0, name.size() - kRsi.size())};
}

/// Those that the controller loads because a program names them.
RsiContexts loaded_contexts(const config::Scenario& scenario, const std::vector<krl::Source>& programs) {
  const auto is_named = [&](const std::string& name) {
    return name == kContext || std::ranges::any_of(programs, [&](const krl::Source& program) {
             return program.text.find('"' + name + '"') != std::string::npos;
           });
  };
  RsiContexts contexts;
  for (const auto& [path, text] : files_of(scenario)) {
    for (const std::string& name : context_names(fs::path{path}.filename())) {
      if (contexts.contains(name) || !is_named(name)) continue;
      auto context = rsi::parse_context(text);
      if (!context) throw config::ConfigError{path + ": " + context.error()};
      contexts.emplace(name, *std::move(context));
    }
  }
  contexts.emplace(kContext, rsi::truepose_context({}));  // what the shipped files are written from
  return contexts;
}

void put(rsi::Context& context, std::string_view type, const std::string& parameter,
         const std::string& value) {
  for (rsi::ContextObject& object : context.objects) {
    if (object.type == type) object.values[parameter] = value;
  }
}

/// What the scenario has in place of what the context says.
void adapt(rsi::Context& context, const std::string& name, const config::Scenario& scenario) {
  if (scenario.rsi_timeout_cycles)
    put(context, "ETHERNET", "Timeout", std::to_string(*scenario.rsi_timeout_cycles));
  if (scenario.rsi_decimals) put(context, "ETHERNET", "Precision", std::to_string(*scenario.rsi_decimals));
  for (int axis = 1; scenario.axis_corr_limit_deg && axis <= 6; ++axis) {
    const std::string number = std::to_string(axis);
    put(context, "AXISCORR", "LowerLimA" + number, formatted("%g", -*scenario.axis_corr_limit_deg));
    put(context, "AXISCORR", "UpperLimA" + number, formatted("%g", *scenario.axis_corr_limit_deg));
    put(context, "AXISCORRMON", "MaxA" + number, formatted("%g", *scenario.axis_corr_limit_deg + 1));
  }
  if (const auto flow = RsiFlow::of(context); !flow)
    throw config::ConfigError{"the RSI context " + name + ": " + flow.error()};
}

}  // namespace

ControllerSetup controller_setup(const config::Scenario& scenario) {
  ControllerSetup setup{.nominal = scenario.nominal,
                        .model = scenario.robot_model,
                        .serial = scenario.robot_serial,
                        .start = home(scenario),
                        .programs = {},
                        .contexts = {kContext},
                        .selected = scenario.selected,
                        .pass_advance_run = scenario.pass_advance_run,
                        .stream_path = scenario.stream_path};
  for (const EmbeddedText& file : system_files()) {
    const std::string name = fs::path{file.name}.filename();
    setup.programs.push_back({name == "config.dat" ? "$config.dat" : name, std::string{file.text}});
  }
  for (auto& [path, text] : files_of(scenario)) {
    const fs::path file{path};
    if (is_krl(file)) setup.programs.push_back({file.filename(), std::move(text)});
    if (file.extension() == ".xml" && file.parent_path().filename() == "eki")
      setup.eki_files.emplace(file.stem(), std::move(text));
  }
  if (!scenario.archive.empty()) {
    // What the archive declares otherwise must not keep the rest from being loaded.
    for (krl::Source& source : setup.programs) source.is_partial = true;
    replace_with(setup.programs, archive_programs(scenario.archive));
  }
  for (const fs::path& file : scenario.programs)
    replace_with(setup.programs, {{file.filename(), config::read_text_file(file)}});
  const auto is_submit = [](const krl::Source& source) { return module_file(source) == "SPS.SUB"; };
  if (std::ranges::none_of(setup.programs, is_submit)) setup.programs.push_back(idle_submit());
  return setup;
}

RsiContexts rsi_contexts(const config::Scenario& scenario, const std::vector<krl::Source>& programs) {
  RsiContexts contexts = loaded_contexts(scenario, programs);
  for (auto& [name, context] : contexts) adapt(context, name, scenario);
  return contexts;
}

}  // namespace truepose::sim
