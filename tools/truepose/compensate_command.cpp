#include <CLI/CLI.hpp>
#include <memory>

#include "tools/truepose/arm_files.hpp"
#include "tools/truepose/compensate_program.hpp"
#include "tools/truepose/compensate_targets.hpp"
#include "tools/truepose/offline_commands.hpp"

namespace truepose::tools {

namespace {

struct CompensateOptions {
  TargetOptions targets;
  ProgramOptions program;
  double singular_below_deg = CompensationOptions{}.singular_below * kDegPerRad;
  double singular_bound_deg = CompensationOptions{}.singular_bound * kDegPerRad;
  double largest_correction_deg = CompensationOptions{}.largest_correction * kDegPerRad;
};

int run_compensate(CompensateOptions options) {
  TargetOptions& targets = options.targets;
  targets.bounds.singular_below = options.singular_below_deg * kRadPerDeg;
  targets.bounds.singular_bound = options.singular_bound_deg * kRadPerDeg;
  targets.bounds.largest_correction = options.largest_correction_deg * kRadPerDeg;
  const RobotModel nominal = config::load_robot(targets.arm.robot);
  const config::ModelFile model = load_model_of(nominal, targets.arm.model);
  if (options.program.src.empty()) {
    targets.X_FT = frame_of(options.program.tool);
    return run_compensate_targets(targets, nominal, model);
  }
  ProgramOptions& program = options.program;
  program.robot = targets.arm.robot;
  program.out_src = targets.out_file;
  program.as_json = targets.as_json;
  program.bounds = targets.bounds;
  return run_compensate_program(program, nominal, model.cell.robot);
}

void add_target_options(CLI::App& command, CLI::Option_group& group, TargetOptions& options) {
  group.add_option(
      "--joints", options.joints_file,
      "Joint positions (CSV: q1..qN in deg or mm; - reads standard input): the real arm stands where the "
      "nominal arm would");
  CLI::Option* poses = group.add_option(
      "--poses", options.poses_file,
      "Poses of the flange (of the TCP with --tool) in the robot base frame (CSV: x,y,z in mm; a,b,c in deg; "
      "optionally KUKA's status and turn s,t; - reads standard input), or x,y,z alone: positions, the "
      "orientation left to the smallest change of the joints. Each is reached on the branch nearest to the "
      "one before it");
  command
      .add_option("--near", options.near,
                  "Joint positions (deg, mm) that the first pose is to be near to; otherwise the middle of "
                  "the joints' ranges")
      ->delimiter(',')
      ->needs(poses);
  command
      .add_flag("--position-only", options.position_only,
                "Only the position counts: the smallest change of the joints that reaches it")
      ->excludes("--program");
  command
      .add_option("--report", options.report_file,
                  "Write corrections, residuals and standard deviations as charts here (HTML)")
      ->excludes("--program");
}

void add_bound_options(CLI::App& command, CompensateOptions& options) {
  command
      .add_option("--singular-below", options.singular_below_deg,
                  "Angle (deg) between axes 4 and 6 below which corrections may be damped, position before "
                  "orientation; 0 = never")
      ->check(CLI::Range(0.0, 90.0))
      ->capture_default_str();
  command
      .add_option("--singular-bound", options.singular_bound_deg,
                  "What axes 4 and 6 may be turned there against each other (deg)")
      ->check(CLI::Range(0.001, 90.0))
      ->capture_default_str();
  command
      .add_option(
          "--largest-correction", options.largest_correction_deg,
          "Targets that would correct a joint by more (deg) are refused: only a singularity asks for it")
      ->check(CLI::Range(0.001, 180.0))
      ->capture_default_str();
}

}  // namespace

void add_compensate_command(CLI::App& app, int& exit_code) {
  const auto options = std::make_shared<CompensateOptions>();
  TargetOptions& targets = options->targets;
  CLI::App* command =
      app.add_subcommand("compensate", "Joint positions at which the real arm stands where it should");
  command->add_option("--robot", targets.arm.robot, "Robot file (YAML)")->required();
  command->add_option("--model", targets.arm.model, "Model file of the calibrated arm")->required();
  CLI::Option_group* group = command->add_option_group("targets", "What the real arm should reach");
  add_program_options(*command, *group, options->program);
  add_target_options(*command, *group, targets);
  group->require_option(1);
  add_bound_options(*command, *options);
  command->add_option("--out", targets.out_file,
                      "Write the joint positions (CSV; - is standard output) or the program here");
  command->add_flag("--json", targets.as_json, "One JSON document");
  command->callback([options, &exit_code] { exit_code = run_compensate(*options); });
}

}  // namespace truepose::tools
