#pragma once

#include <filesystem>
#include <optional>
#include <vector>

#include "core/compensate/target_compensation.hpp"

namespace CLI {
class App;
class Option_group;
}  // namespace CLI

namespace truepose::tools {

/// Files and settings of `truepose compensate --program`. An empty path means not given.
struct ProgramOptions {
  std::filesystem::path robot;
  std::filesystem::path src, dat, config_dat;
  std::filesystem::path out_src, out_dat;
  std::vector<double> tool, base;  ///< at the start: X, Y, Z (mm), A, B, C (deg), or empty
  CompensationOptions bounds;
  bool as_json = false;
};

/// The frame of x,y,z,a,b,c (mm, deg), or nothing for none.
std::optional<Eigen::Isometry3d> frame_of(const std::vector<double>& v);

/// @param targets  the options of which one says what the command is about
void add_program_options(CLI::App& command, CLI::Option_group& targets, ProgramOptions& options);

/// Corrects a KRL program, writes it where that was asked for, and prints what was done.
/// @return kFailed where a position stays uncorrected that should not. Throws ConfigError; then nothing is
/// written.
int run_compensate_program(const ProgramOptions& options, const RobotModel& nominal,
                           const RobotModel& calibrated);

}  // namespace truepose::tools
