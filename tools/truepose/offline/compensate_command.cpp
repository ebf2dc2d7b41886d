#include <memory>

#include "core/math/angles.hpp"
#include "tools/truepose/offline/compensate.hpp"
#include "tools/truepose/offline/offline_commands.hpp"

namespace truepose::tools {
namespace {

struct CompensateCommand {
  CompensateOptions options;
  std::vector<double> tool, base;  ///< x,y,z,a,b,c (mm, deg)
  double singular_below_deg = CompensationOptions{}.singular_below * kDegPerRad;
  double singular_bound_deg = CompensationOptions{}.singular_bound * kDegPerRad;
  double largest_correction_deg = CompensationOptions{}.largest_correction * kDegPerRad;
};

std::optional<Eigen::Isometry3d> frame_of(const std::vector<double>& v) {
  if (v.empty()) return std::nullopt;
  return pose_from_kuka({v[0], v[1], v[2]}, {v[3], v[4], v[5]});
}

int run_compensate(const CompensateCommand& command) {
  CompensateOptions options = command.options;
  options.bounds.singular_below = command.singular_below_deg * kRadPerDeg;
  options.bounds.singular_bound = command.singular_bound_deg * kRadPerDeg;
  options.bounds.largest_correction = command.largest_correction_deg * kRadPerDeg;
  options.X_FT = frame_of(command.tool);
  options.X_base = frame_of(command.base);
  const RobotModel nominal = config::load_robot(options.arm.robot);
  const config::ModelFile model = load_model_of(nominal, options.arm.model);
  return options.src.empty() ? run_compensate_targets(options, nominal, model)
                             : run_compensate_program(options, nominal, model.cell.robot);
}

}  // namespace

Command compensate_command() {
  const auto command = std::make_shared<CompensateCommand>();
  CompensateCommand& c = *command;
  CompensateOptions& o = command->options;
  return {
      .name = "compensate",
      .help = "Joint positions at which the real arm stands where it should",
      .options =
          {Option("--robot", &o.arm.robot, "Robot file (YAML)", {.required = true}),
           Option("--model", &o.arm.model, "Model file of the calibrated arm", {.required = true}),
           Option(
               "--program", &o.src,
               "KRL program (SRC): written again with its taught positions moved so that the real arm stands where "
               "the nominal one would have. Paths between them stay the controller's. $WORLD is taken as the "
               "robot's foot",
               {.is_subject = true}),
           Option("--dat", &o.dat, "Data list of the program (DAT)", {.needs = {"--program"}}),
           Option("--out-dat", &o.out_dat, "Write the data list here", {.needs = {"--program", "--dat"}}),
           Option("--config-dat", &o.config_dat,
                  "The controller's $config.dat: TOOL_DATA, BASE_DATA, home positions",
                  {.needs = {"--program"}}),
           Option(
               "--tool", &c.tool,
               "Tool on the flange as x,y,z,a,b,c (mm, deg): whose position comes first, and whose poses --poses "
               "are; with a program, the one in force where it starts",
               {.count = 6}),
           Option("--base", &c.base, "Base in force where a program starts, as x,y,z,a,b,c (mm, deg)",
                  {.count = 6, .needs = {"--program"}}),
           Option(
               "--joints", &o.joints_file,
               "Joint positions (CSV: q1..qN in deg or mm; - reads standard input): the real arm stands where the "
               "nominal arm would",
               {.is_subject = true}),
           Option(
               "--poses", &o.poses_file,
               "Poses of the flange (of the TCP with --tool) in the robot base frame (CSV: x,y,z in mm; a,b,c in "
               "deg; optionally KUKA's status and turn s,t; - reads standard input), or x,y,z alone: positions, "
               "the orientation left to the smallest change of the joints. Each is reached on the branch nearest "
               "to the one before it",
               {.is_subject = true}),
           Option(
               "--near", &o.near,
               "Joint positions (deg, mm) that the first pose is to be near to; otherwise the middle of the "
               "joints' ranges",
               {.needs = {"--poses"}}),
           Option("--position-only", &o.position_only,
                  "Only the position counts: the smallest change of the joints that reaches it",
                  {.excludes = {"--program"}}),
           Option("--report", &o.report_file,
                  "Write corrections, residuals and standard deviations as charts here (HTML)",
                  {.excludes = {"--program"}}),
           Option("--singular-below", &c.singular_below_deg,
                  "Angle (deg) between axes 4 and 6 below which corrections may be damped, position before "
                  "orientation; 0 = never",
                  {.shows_default = true, .check = in_range(0.0, 90.0)}),
           Option("--singular-bound", &c.singular_bound_deg,
                  "What axes 4 and 6 may be turned there against each other (deg)",
                  {.shows_default = true, .check = in_range(0.001, 90.0)}),
           Option(
               "--largest-correction", &c.largest_correction_deg,
               "Targets that would correct a joint by more (deg) are refused: only a singularity asks for it",
               {.shows_default = true, .check = in_range(0.001, 180.0)}),
           Option("--out", &o.out_file,
                  "Write the joint positions (CSV; - is standard output) or the program here"),
           Option("--json", &o.as_json, "One JSON document")},
      .run = [command] { return run_compensate(*command); },
      .subjects = "What the real arm should reach"};
}

}  // namespace truepose::tools
