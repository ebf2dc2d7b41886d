#include <memory>

#include "core/arm/payload.hpp"
#include "core/math/angles.hpp"
#include "tools/truepose/offline/compensate.hpp"
#include "tools/truepose/offline/offline_commands.hpp"
#include "tools/truepose/offline/table_options.hpp"
#include "tools/truepose/progress_line.hpp"

namespace truepose::tools {

using config::ConfigError;

namespace {

struct CompensateCommand {
  CompensateOptions options;
  TableOptions table;
  std::vector<double> temperature_c;
  double singularity_threshold_deg = CompensationOptions{}.singular_below * kDegPerRad;
  double singularity_limit_deg = CompensationOptions{}.singular_bound * kDegPerRad;
  double max_correction_deg = CompensationOptions{}.largest_correction * kDegPerRad;
  std::vector<double> payload;  ///< kg, and its centre in the flange frame, mm; empty: the model's
};

/// The model, its arm with what it carries now.
config::ModelFile loaded_model(const CompensateCommand& command, const RobotModel& nominal) {
  config::ModelFile model = load_model_of(nominal, command.options.arm.model);
  const std::vector<double>& payload = command.payload;
  if (payload.empty()) {
    note_open_payload(model, command.options.arm.model, "--payload says it");
    return model;
  }
  if (payload.size() != 4 || payload[0] < 0)
    throw ConfigError("--payload: expected four numbers, the first 0 or more");
  auto arm = carrying(model.cell.robot, {payload[0], {payload[1], payload[2], payload[3]}});
  if (!arm) throw ConfigError("--payload: " + arm.error());
  model.cell.robot = *std::move(arm);
  return model;
}

void check_temperatures(const CompensateCommand& command, const config::ModelFile& model) {
  if (!model.thermal)
    throw bad_usage("--temperatures: " + command.options.arm.model.string() +
                    " has no thermal expansion: calibrate from points with columns temp1..");
  if (command.temperature_c.size() != model.cell.robot.joints.size())
    throw bad_usage("--temperatures: expected " + std::to_string(model.cell.robot.joints.size()) +
                    ", one a joint, found " + std::to_string(command.temperature_c.size()));
}

int run_compensate(const CompensateCommand& command) {
  CompensateOptions options = command.options;
  options.bounds.singular_below = command.singularity_threshold_deg * kRadPerDeg;
  options.bounds.singular_bound = command.singularity_limit_deg * kRadPerDeg;
  options.bounds.largest_correction = command.max_correction_deg * kRadPerDeg;
  options.reading = reading_of(command.table);
  const RobotModel nominal = config::load_robot(options.arm.robot);
  config::ModelFile kept = loaded_model(command, nominal);
  if (!command.temperature_c.empty()) check_temperatures(command, kept);
  const config::ModelFile model = as_warm(kept, command.temperature_c, options.arm.model);
  const bool prints_rows = options.out_file.empty() || options.out_file == "-";
  const auto line = prints_rows ? nullptr : std::make_unique<ProgressLine>("compensation");
  if (!options.archive.empty()) return run_compensate_archive(options, nominal, model);
  return options.src.empty() ? run_compensate_targets(options, nominal, model)
                             : run_compensate_program(options, nominal, model);
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
          {Option("--robot", &o.arm.robot, "Robot file (YAML)",
                  {.required = true, .place = "ROBOT", .file = FileUse::Read}),
           Option("--model", &o.arm.model, "Model file of the calibrated arm",
                  {.required = true, .place = "MODEL", .file = FileUse::Read}),
           Option(
               "--program", &o.src,
               "KRL program (SRC): written again with its taught positions moved to where the real arm stands as "
               "the nominal one would have. Paths between them stay the controller's. $WORLD is taken as the "
               "robot's foot",
               {.is_subject = true, .file = FileUse::Read}),
           Option(
               "--dat", &o.dats,
               "Data list of the program (DAT); given again, other lists with GLOBAL positions that it uses",
               {.repeats = true, .needs = {"--program"}, .file = FileUse::Read}),
           Option("--out-dat", &o.out_dats, "Write the data list here; one for each --dat, in their order",
                  {.repeats = true, .needs = {"--program", "--dat"}, .file = FileUse::Written}),
           Option(
               "--archive", &o.archive,
               "All programs of a controller: the folder that holds KRC, or the archive's .zip. Positions that "
               "several programs use are corrected once; --out is a folder, which gets the files that change",
               {.type = "DIR|ZIP",
                .excludes = {"--tool", "--base"},
                .is_subject = true,
                .file = FileUse::Read}),
           Option("--config-dat", &o.config_dat,
                  "The controller's $config.dat: TOOL_DATA, BASE_DATA, home positions",
                  {.needs = {"--program"}, .file = FileUse::Read}),
           Option(
               "--tool", &o.tool,
               "Tool on the flange: a file of truepose tool, or its numbers in mm and deg. Its TCP's position "
               "comes first, and its poses --poses are; with a program, a file is the tool of its number, numbers "
               "are the tool that is set where it starts",
               {.type = kFrameType, .file = FileUse::Read}),
           Option(
               "--base", &o.base,
               "Base: a file of truepose base, or its numbers. --poses stand in it; with a program as --tool",
               {.type = kFrameType, .excludes = {"--joints"}, .file = FileUse::Read}),
           Option(
               "--positioner", &o.positioner,
               "A file of truepose positioner: --poses stand in the workpiece on its table, which is turned "
               "to e1[,e2] (deg or mm), further columns of --poses",
               {.needs = {"--poses"}, .excludes = {"--base"}, .file = FileUse::Read}),
           Option(
               "--joints", &o.joints_file,
               "Joint positions (CSV: q1..qN in deg or mm; - reads standard input): the real arm stands where the "
               "nominal arm would",
               {.is_subject = true, .file = FileUse::Read}),
           Option(
               "--poses", &o.poses_file,
               "Poses of the flange (of the TCP with --tool) in the robot base frame (CSV: x,y,z in mm; a,b,c in "
               "deg; optionally KUKA's status and turn s,t; - reads standard input), or x,y,z alone: positions, "
               "the orientation left to the smallest change of the joints. Each is reached on the branch nearest "
               "to the one before it",
               {.is_subject = true, .file = FileUse::Read}),
           Option(
               "--payload", &c.payload,
               "What the flange carries now, where that is not what it carried when it was measured: kg, and its "
               "centre in the flange frame, mm",
               {.type = "KG,X,Y,Z"}),
           Option(
               "--near", &o.near,
               "Joint positions (deg, mm) that the first pose is to be near to; otherwise the middle of the "
               "joints' ranges",
               {.type = "Q1,..", .needs = {"--poses"}}),
           columns_option(c.table),
           units_option(c.table),
           Option("--position-only", &o.position_only,
                  "Only the position counts: the smallest change of the joints that reaches it",
                  {.excludes = {"--program", "--archive"}}),
           Option(
               "--max-orientation-residual", &o.max_orientation_residual_deg,
               "Rows that give up more orientation (deg) next to a singularity are counted, and the command "
               "ends with 1",
               {.shows_default = true,
                .check = in_range(0.0, 180.0),
                .type = "DEG",
                .excludes = {"--program", "--archive"}}),
           Option("--max-position-residual", &o.max_position_residual_mm, "The same for the position (mm)",
                  {.shows_default = true,
                   .check = in_range(0.0, 1000.0),
                   .type = "MM",
                   .excludes = {"--program", "--archive"}}),
           Option(
               "--temperatures", &c.temperature_c,
               "Of the drives (C), one a joint, for a model with thermal expansion; otherwise its reference",
               {.check = in_range(-50.0, 200.0), .type = "C,.."}),
           Option("--report", &o.report_file,
                  "Write corrections, residuals and standard deviations as charts here (HTML)",
                  {.excludes = {"--program", "--archive"}, .file = FileUse::Written}),
           Option("--singularity-threshold", &c.singularity_threshold_deg,
                  "Angle (deg) between axes 4 and 6 below which corrections may be damped, position before "
                  "orientation; 0 = never",
                  {.shows_default = true, .check = in_range(0.0, 90.0), .type = "DEG"}),
           Option("--singularity-limit", &c.singularity_limit_deg,
                  "What axes 4 and 6 may be turned there against each other (deg)",
                  {.shows_default = true, .check = in_range(0.001, 90.0), .type = "DEG"}),
           Option(
               "--max-correction", &c.max_correction_deg,
               "Targets that would correct a joint by more (deg) are refused: only a singularity asks for it",
               {.shows_default = true, .check = in_range(0.001, 180.0), .type = "DEG"}),
           Option(
               "--out", &o.out_file,
               "Write the joint positions (CSV; - is standard output), the program or the archive's files here",
               {.file = FileUse::Written}),
           Option("--json", &o.as_json, "One JSON document")},
      .run = [command] { return run_compensate(*command); },
      .subjects = "What the real arm should reach",
      .examples = {{"compensate arm.yaml model.yaml --poses targets.csv -o joints.csv",
                    "Joints at which the flange is at each pose"},
                   {"compensate arm.yaml model.yaml --poses targets.csv --tool gun.yaml --base fixture.yaml",
                    "The same for a TCP in a work frame"},
                   {"compensate arm.yaml model.yaml --archive backup.zip -o corrected",
                    "All KRL programs of a controller"}}};
}

}  // namespace truepose::tools
