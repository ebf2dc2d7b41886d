#include <fmt/core.h>

#include <algorithm>
#include <iostream>

#include "config/text_file.hpp"
#include "proto/control/json_text.hpp"
#include "proto/krl/program_statement.hpp"
#include "proto/record/json_io.hpp"
#include "tools/truepose/krl/program_report.hpp"
#include "tools/truepose/offline/compensate.hpp"
#include "tools/truepose/written_files.hpp"

namespace truepose::tools {
namespace {

using config::ConfigError;
using config::TextFile;

// ---- The files ----

/// The files of a program, in the order of its ProgramText.
struct ProgramFiles {
  std::vector<std::string> names, bytes;
  std::vector<std::string> out;  ///< where each is to be written; empty: nowhere
  krl::ProgramText text;
};

/// The data list of a program has its name, where several are given; of the others what is GLOBAL counts.
std::string module_of(const std::filesystem::path& dat, const CompensateOptions& options) {
  const bool is_own = options.dats.size() == 1 ||
                      krl::in_capitals(dat.stem().string()) == krl::in_capitals(options.src.stem().string());
  return is_own ? "" : dat.string();
}

ProgramFiles files_of(const CompensateOptions& options) {
  using Role = krl::SourceText::Role;
  ProgramFiles files;
  std::vector<krl::SourceText>& texts = files.text.files;
  const auto add = [&](const std::filesystem::path& file, krl::SourceText source, const std::string& out) {
    files.names.push_back(file.string());
    files.bytes.push_back(config::read_bytes(file));
    files.out.push_back(out);
    texts.push_back(std::move(source));
  };
  add(options.src, {.role = Role::Program}, options.out_file);
  for (std::size_t i = 0; i < options.dats.size(); ++i)
    add(options.dats[i], {.role = Role::Data, .module = module_of(options.dats[i], options)},
        i < options.out_dats.size() ? options.out_dats[i] : "");
  if (!options.config_dat.empty())
    add(options.config_dat, {.role = Role::Config, .module = "$CONFIG", .is_changeable = false}, "");
  for (std::size_t i = 0; i < texts.size(); ++i) texts[i].text = files.bytes[i];
  return files;
}

/// Refuses a file that is something else, as a robot file: there would be nothing to correct in it.
void expect_krl(const ProgramFiles& files) {
  const auto statements = krl::read_statements(files.text.files.front().text);
  bool has_routine = !statements;  // what cannot be read is refused with its place
  if (statements)
    statements->steps.each([&](const krl::ProgramStatement& each) { has_routine |= each.is_head; });
  if (!has_routine)
    throw ConfigError(files.names.front() + ": has no DEF, so it is no KRL program. Give the program's .src");
}

void write(const CompensateOptions& options, const ProgramFiles& files, const ProgramCompensation& done) {
  if (options.out_file.empty() && options.out_dats.empty()) return;
  std::vector<TextFile> written;
  for (std::size_t file = 0; file < files.out.size(); ++file) {
    const auto edits = done.edits.find(file);
    if (edits != done.edits.end() && files.out[file].empty())
      throw ConfigError(files.names[file] + ": positions in it change too; say where to write it with " +
                        (file == 0                  ? "--out"
                         : options.dats.size() == 1 ? "--out-dat"
                                                    : "--out-dat, one for each --dat in their order"));
    if (files.out[file].empty()) continue;
    written.push_back({files.out[file],
                       krl::rewritten(files.text.files[file].text,
                                      edits == done.edits.end() ? std::vector<krl::Edit>{} : edits->second)});
  }
  config::write_together(written);
}

// ---- Tools and bases that were measured ----

/// A frame given by its numbers is active where the program starts. A measured frame is in the controller
/// under its number.
krl::StartFrames start_of(const std::optional<Tool>& tool, const std::optional<Base>& base) {
  krl::StartFrames start;
  if (tool && tool->number == 0) start.tool = tool->X_controller;
  if (tool && tool->number > 0) start.tools[tool->number] = tool->X_controller;
  if (base && base->number == 0) start.base = base->X;
  if (base && base->number > 0) start.bases[base->number] = base->X;
  return start;
}

/// A frame that no motion uses was meant for another program, or has another number there.
void refuse_unused(const krl::Program& program, const char* option, const char* table, int number,
                   std::size_t krl::Step::*frame) {
  const auto uses = [&](const krl::Step& step) { return program.frames[step.*frame].number == number; };
  if (number == 0 || std::ranges::any_of(program.steps, uses)) return;
  throw ConfigError(
      fmt::format("{}: is of {}[{}], which no motion of the program uses", option, table, number));
}

RealFrames real_frames(const std::optional<Tool>& tool, const std::optional<Base>& base) {
  RealFrames real;
  if (tool && tool->number > 0) real.tools[tool->number] = tool->X_FT;
  if (base && base->number > 0) real.bases[base->number] = base->X;
  return real;
}

}  // namespace

int run_compensate_program(const CompensateOptions& options, const RobotModel& nominal,
                           const config::ModelFile& model) {
  const auto inverse = StatusTurnInverse::by_search(nominal);
  if (!inverse) throw ConfigError(options.arm.robot.string() + ": " + inverse.error());

  const ProgramFiles files = files_of(options);
  expect_krl(files);
  const ProgramPlaces places(files.text, files.names);
  const auto refuse = [&](const krl::ProgramFault& fault) -> ConfigError {
    return ConfigError(places.line_and_column(fault.spot) + ": " + fault.what);
  };
  const auto tool = tool_of(options.tool, "--tool", nominal, model);
  const auto base = base_of(options.base, "--base", model);
  const auto program = krl::read_program(files.text, start_of(tool, base));
  if (!program) throw refuse(program.error());
  refuse_unused(*program, "--tool", "TOOL_DATA", tool ? tool->number : 0, &krl::Step::tool);
  refuse_unused(*program, "--base", "BASE_DATA", base ? base->number : 0, &krl::Step::base);
  const auto done = compensate_program(*program, nominal, *inverse, model.cell.robot, options.bounds,
                                       real_frames(tool, base));
  if (!done) throw refuse(done.error());

  write(options, files, *done);
  if (options.as_json) {
    std::cout << control::json_text(record::to_json(ProgramDocument{*done, places})) << '\n';
  } else {
    std::cout << program_summary(options.src.string(), *done, places);
    note_written({options.out_file});
    for (const std::string& file : options.out_dats) note_written({file});
  }
  const auto uncorrected = std::ranges::count_if(done->left, &krl::LeftAlone::absolute);
  if (uncorrected == 0) return kDone;
  throw CommandError{kFailed, fmt::format("{}: {} uncorrected", options.src.string(),
                                          uncorrected == 1 ? "1 target stays"
                                                           : fmt::format("{} targets stay", uncorrected))};
}

}  // namespace truepose::tools
