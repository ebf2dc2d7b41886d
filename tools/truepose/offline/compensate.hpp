#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "config/table/table_reading.hpp"
#include "core/compensate/target_compensation.hpp"
#include "tools/truepose/offline/arm_options.hpp"
#include "tools/truepose/offline/frame_options.hpp"

namespace truepose::tools {

/// What `truepose compensate` is asked for. What is empty was not given.
struct CompensateOptions {
  ArmFiles arm;
  CompensationOptions bounds;
  FrameWords tool, base;  ///< of a program those at its start, or in place of its own
  std::string out_file;   ///< "-" = standard output
  bool as_json = false;

  // Targets, joints or poses
  std::string joints_file, poses_file;  ///< one of them; "-" = standard input
  std::filesystem::path positioner;     ///< on whose table the poses stand
  std::string report_file;
  config::TableReading reading;  ///< of them
  std::vector<double> near;      ///< deg (mm) per joint
  bool position_only = false;
  double max_orientation_residual_deg = 0.1;  ///< of orientation, beyond which a row is counted
  double max_position_residual_mm = 0.01;     ///< of position, likewise

  // A KRL program
  std::filesystem::path src, config_dat;
  std::vector<std::string> dats, out_dats;

  // All programs of a controller
  std::filesystem::path archive;  ///< folder or .zip; out_file is the folder for what changes
};

/// Solves the targets one by one and writes the joints to command: rows as they come, or one JSON document.
/// Throws CommandError where a target is not reached, which leaves no file, and ConfigError.
int run_compensate_targets(const CompensateOptions& options, const RobotModel& nominal,
                           const config::ModelFile& model);

/// Corrects a KRL program, writes it where that was asked for, and prints what was done. Throws CommandError
/// where a position stays uncorrected that should not, and ConfigError; then nothing is written.
int run_compensate_program(const CompensateOptions& options, const RobotModel& nominal,
                           const config::ModelFile& model);

/// The same for all programs of a controller's archive: the files that change are written below the folder
/// out_file, all or none.
int run_compensate_archive(const CompensateOptions& options, const RobotModel& nominal,
                           const config::ModelFile& model);

}  // namespace truepose::tools
