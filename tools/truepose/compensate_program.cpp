#include "tools/truepose/compensate_program.hpp"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <boost/json.hpp>
#include <iostream>

#include "config/text_file.hpp"
#include "core/math/angles.hpp"
#include "tools/truepose/exit_code.hpp"
#include "tools/truepose/program_compensation.hpp"
#include "tools/truepose/program_summary.hpp"

namespace truepose::tools {

namespace {

using config::ConfigError;
using config::TextFile;

std::string bytes_of(const std::filesystem::path& file) {
  return file.empty() ? std::string{} : config::read_bytes(file);
}

/// A program that is corrected twice is wrong by as much as before.
void refuse_to_overwrite(const std::filesystem::path& in, const std::filesystem::path& out) {
  std::error_code ignored;
  if (!in.empty() && !out.empty() && std::filesystem::equivalent(in, out, ignored))
    throw ConfigError(out.string() +
                      ": is the taught program itself, which is needed for the next correction; "
                      "write to another file");
}

void require_place(bool is_changed, const std::filesystem::path& in, const std::filesystem::path& out,
                   const char* option) {
  if (is_changed && out.empty())
    throw ConfigError(in.string() + ": positions in it change too; say where to write it with " + option);
}

void write(const ProgramOptions& options, const krl::ProgramText& text, const ProgramCompensation& done) {
  std::vector<TextFile> files;
  if (options.out_src.empty() && options.out_dat.empty()) return;
  require_place(!done.src_edits.empty(), options.src, options.out_src, "--out");
  require_place(!done.dat_edits.empty(), options.dat, options.out_dat, "--out-dat");
  if (!options.out_src.empty()) files.push_back({options.out_src, krl::rewritten(text.src, done.src_edits)});
  if (!options.out_dat.empty()) files.push_back({options.out_dat, krl::rewritten(text.dat, done.dat_edits)});
  config::write_together(files);
}

}  // namespace

std::optional<Eigen::Isometry3d> frame_of(const std::vector<double>& v) {
  if (v.empty()) return std::nullopt;
  return pose_from_kuka({v[0], v[1], v[2]}, {v[3], v[4], v[5]});
}

void add_program_options(CLI::App& command, CLI::Option_group& targets, ProgramOptions& options) {
  CLI::Option* program = targets.add_option("--program", options.src,
                                            "KRL program (SRC): written again with its taught positions "
                                            "moved so that the real arm stands where the "
                                            "nominal one would have. Paths between them stay the "
                                            "controller's. $WORLD is taken as the robot's foot");
  const auto add = [&](const char* name, auto& value, const char* help) {
    return command.add_option(name, value, help)->needs(program);
  };
  CLI::Option* dat = add("--dat", options.dat, "Data list of the program (DAT)");
  add("--out-dat", options.out_dat, "Write the data list here")->needs(dat);
  add("--config-dat", options.config_dat,
      "The controller's $config.dat: TOOL_DATA, BASE_DATA, home positions");
  command
      .add_option("--tool", options.tool,
                  "Tool on the flange as x,y,z,a,b,c (mm, deg): whose position comes first, and whose poses "
                  "--poses are; with a program, the one in force where it starts")
      ->delimiter(',')
      ->expected(6);
  add("--base", options.base, "Base in force where a program starts, as x,y,z,a,b,c (mm, deg)")
      ->delimiter(',')
      ->expected(6);
}

int run_compensate_program(const ProgramOptions& options, const RobotModel& nominal,
                           const RobotModel& calibrated) {
  refuse_to_overwrite(options.src, options.out_src);
  refuse_to_overwrite(options.dat, options.out_dat);
  const auto inverse = StatusTurnInverse::of(nominal);
  if (!inverse) throw ConfigError(options.robot.string() + ": " + inverse.error());

  const std::string src = bytes_of(options.src), dat = bytes_of(options.dat),
                    config_dat = bytes_of(options.config_dat);
  const krl::ProgramText text{src, dat, config_dat};
  const ProgramPlaces places(text, options.src, options.dat, options.config_dat);
  const auto refuse = [&](const krl::ProgramFault& fault) -> ConfigError {
    return ConfigError(places.line_and_column(fault.spot) + ": " + fault.what);
  };
  const auto program = krl::read_program(text, {frame_of(options.tool), frame_of(options.base)});
  if (!program) throw refuse(program.error());
  const auto done = compensate_program(*program, nominal, *inverse, calibrated, options.bounds);
  if (!done) throw refuse(done.error());

  write(options, text, *done);
  if (options.as_json) {
    std::cout << program_document(*done, places) << '\n';
  } else {
    std::cout << program_summary(*done, places);
  }
  const auto uncorrected = std::ranges::count_if(done->left, &krl::LeftAlone::absolute);
  if (uncorrected == 0) return kDone;
  std::cerr << "truepose: " << options.src.string() << ": " << uncorrected
            << (uncorrected == 1 ? " target stays" : " targets stay") << " uncorrected\n";
  return kFailed;
}

}  // namespace truepose::tools
