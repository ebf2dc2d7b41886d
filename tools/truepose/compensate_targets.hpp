#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/compensate/target_compensation.hpp"
#include "tools/truepose/arm_files.hpp"

namespace truepose::tools {

/// Targets of `truepose compensate` in a file: joints or poses.
struct TargetOptions {
  ArmFiles arm;
  std::string joints_file, poses_file;  ///< one of them; "-" = standard input
  std::string out_file, report_file;    ///< may be empty; "-" = standard output
  std::vector<double> near;             ///< deg (mm) per joint, or empty
  std::optional<Eigen::Isometry3d> X_FT;
  CompensationOptions bounds;
  bool position_only = false;
  bool as_json = false;
};

/// Solves the targets one by one and writes the joints to command: rows as they come, or one JSON document.
/// @return the exit code: a target that is not reached ends it, and leaves no file. Throws ConfigError.
int run_compensate_targets(const TargetOptions& options, const RobotModel& nominal,
                           const config::ModelFile& model);

}  // namespace truepose::tools
