// What an arm is to others: its flange poses, and files for other programs.
#include <array>
#include <cstdio>
#include <iostream>
#include <memory>

#include "config/import/dh_table.hpp"
#include "config/measurement_file.hpp"
#include "config/model_export.hpp"
#include "config/text_file.hpp"
#include "core/arm/forward.hpp"
#include "core/math/angles.hpp"
#include "proto/control/json_text.hpp"
#include "proto/record/json_io.hpp"
#include "tools/truepose/offline/arm_options.hpp"
#include "tools/truepose/offline/offline_commands.hpp"
#include "tools/truepose/offline/table_options.hpp"
#include "tools/truepose/written_files.hpp"

namespace truepose::tools {
namespace {

struct FkCommand {
  ArmFiles arm;
  TableOptions table;
  std::string joints_file;
  bool as_json = false;
};

using RowMajor = std::array<double, 16>;

RowMajor row_major(const Eigen::Isometry3d& X) {
  RowMajor numbers;
  for (int i = 0; i < 16; ++i) numbers[static_cast<std::size_t>(i)] = X(i / 4, i % 4);
  return numbers;
}

/// What is printed as JSON.
struct FlangePoses {
  std::vector<RowMajor> poses;
};
void layout(record::Io& io, FlangePoses& x) { io("poses", x.poses); }

void print_pose(const Eigen::Isometry3d& X) {
  const Eigen::Vector3d abc_deg = kuka_abc_deg(X.linear());
  std::printf("%.6f,%.6f,%.6f,%.8f,%.8f,%.8f\n", X(0, 3), X(1, 3), X(2, 3), abc_deg.x(), abc_deg.y(),
              abc_deg.z());
}

RobotModel calibrated(const RobotModel& nominal, const std::filesystem::path& file) {
  const config::ModelFile model = load_model_of(nominal, file);
  note_open_payload(model, file);
  return model.cell.robot;
}

int run_fk(const FkCommand& command) {
  const RobotModel nominal = config::load_robot(command.arm.robot);
  const RobotModel robot = command.arm.model.empty() ? nominal : calibrated(nominal, command.arm.model);
  const config::TableReading reading = reading_of(command.table);
  const auto joints = config::load_joints(command.joints_file, nominal, &reading);
  if (!command.as_json) {
    std::puts("x,y,z,a,b,c");
    for (const JointVector& q : joints) print_pose(forward_kinematics(robot, q));
    return kDone;
  }
  FlangePoses flange;
  for (const JointVector& q : joints) flange.poses.push_back(row_major(forward_kinematics(robot, q)));
  std::cout << control::json_text(record::to_json(flange)) << '\n';
  return kDone;
}

struct ExportCommand {
  std::string model_file, urdf_file, csv_file, dh_file, robodk_file, kuka_file;
};

/// What a table of links cannot hold, said where the arm has it.
void note_left_out(const RobotModel& robot) {
  if (!robot.coupling.empty())
    print_to_stderr("a DH table has no coupling: its joints are those of the links, not the controller's");
  if (!robot.deviation.empty() || robot.field)
    print_to_stderr("a DH table has no deviations of joints and no residual field: they are left out");
}

int run_export(const ExportCommand& command) {
  if (command.urdf_file.empty() && command.csv_file.empty() && command.dh_file.empty() &&
      command.robodk_file.empty() && command.kuka_file.empty())
    throw bad_usage("--urdf, --csv, --dh, --robodk, --kuka: missing. Give one of them");
  const config::ModelFile model = load_model_to_use(command.model_file);
  const RobotModel& robot = model.cell.robot;
  if (!command.urdf_file.empty()) config::write_text_file(command.urdf_file, config::urdf(robot));
  if (!command.csv_file.empty())
    config::write_text_file(command.csv_file, config::parameter_csv(model.parameters, robot));
  if (!command.dh_file.empty() || !command.robodk_file.empty()) note_left_out(robot);
  if (!command.dh_file.empty())
    config::write_text_file(command.dh_file, config::dh_table_text(robot, config::DhConvention::Modified));
  if (!command.robodk_file.empty())
    config::write_text_file(command.robodk_file, config::robodk_table_text(robot));
  if (!command.kuka_file.empty())
    config::write_text_file(command.kuka_file, config::kuka_corrections_csv(model.parameters, robot));
  note_written(
      {command.urdf_file, command.csv_file, command.dh_file, command.robodk_file, command.kuka_file});
  return kDone;
}

struct RobotExport {
  std::filesystem::path robot;
  std::string urdf_file, dh_file, standard_dh_file, robodk_file;
};

int run_robot_export(const RobotExport& command) {
  const RobotModel robot = config::load_robot(command.robot);
  std::vector<config::TextFile> files;
  const auto add = [&](const std::string& file, std::string (*text)(const RobotModel&)) {
    if (!file.empty()) files.push_back({file, text(robot)});
  };
  add(command.urdf_file, config::urdf);
  add(command.dh_file,
      [](const RobotModel& arm) { return config::dh_table_text(arm, config::DhConvention::Modified); });
  add(command.standard_dh_file,
      [](const RobotModel& arm) { return config::dh_table_text(arm, config::DhConvention::Standard); });
  add(command.robodk_file, config::robodk_table_text);
  if (files.empty()) throw bad_usage("--urdf, --dh, --standard-dh, --robodk: missing. Give one of them");
  if (command.urdf_file.empty() || files.size() > 1) note_left_out(robot);
  config::write_together(files);
  note_written({command.urdf_file, command.dh_file, command.standard_dh_file, command.robodk_file});
  return kDone;
}

}  // namespace

Command fk_command() {
  const auto command = std::make_shared<FkCommand>();
  FkCommand& c = *command;
  return {.name = "fk",
          .help = "Flange poses of joint positions, in the robot base frame",
          .options = {Option("--robot", &c.arm.robot, "Robot file (YAML)",
                             {.required = true, .place = "ROBOT", .file = FileUse::Read}),
                      Option("--model", &c.arm.model,
                             "Model file of the calibrated arm; without it the nominal arm",
                             {.file = FileUse::Read}),
                      Option("--joints", &c.joints_file, "Joint positions (CSV: q1..qN in deg or mm)",
                             {.required = true, .place = "JOINTS", .file = FileUse::Read}),
                      columns_option(c.table), units_option(c.table),
                      Option("--json", &c.as_json, "One JSON document: 16 numbers a pose, row major, mm")},
          .run = [command] { return run_fk(*command); },
          .examples = {{"fk arm.yaml joints.csv", "Poses of the nominal arm"},
                       {"fk arm.yaml joints.csv --model model.yaml", "Poses of the calibrated arm"}}};
}

Command export_command() {
  const auto command = std::make_shared<ExportCommand>();
  ExportCommand& c = *command;
  return {
      .name = "export",
      .help = "Writes a calibrated arm for other programs",
      .options = {Option("--model", &c.model_file, "Model file of the calibrated arm",
                         {.required = true, .place = "MODEL", .file = FileUse::Read}),
                  Option("--urdf", &c.urdf_file,
                         "Kinematics (URDF); deviations of joints and a residual field do not fit into it",
                         {.file = FileUse::Written}),
                  Option("--csv", &c.csv_file, "Every parameter with its unit, sigma and share of the data",
                         {.file = FileUse::Written}),
                  Option("--dh", &c.dh_file,
                         "Modified DH table with Hayati's beta (CSV), which robot import reads",
                         {.file = FileUse::Written}),
                  Option("--robodk", &c.robodk_file, "The same in RoboDK's order of columns (CSV)",
                         {.file = FileUse::Written}),
                  Option("--kuka", &c.kuka_file,
                         "What a KUKA controller itself can take, and what it cannot (CSV)",
                         {.file = FileUse::Written})},
      .run = [command] { return run_export(*command); },
      .examples = {{"export model.yaml --urdf arm.urdf --csv parameters.csv"}}};
}

Command robot_export_command() {
  const auto command = std::make_shared<RobotExport>();
  RobotExport& c = *command;
  return {
      .name = "robot export",
      .help = "Writes a nominal arm for other programs",
      .options = {Option("robot", &c.robot, "Robot file (YAML), or the name of a shipped one",
                         {.required = true, .type = "ROBOT", .file = FileUse::Read}),
                  Option("--urdf", &c.urdf_file, "Kinematics (URDF)", {.file = FileUse::Written}),
                  Option("--dh", &c.dh_file, "Modified DH table (CSV), which robot import reads",
                         {.file = FileUse::Written}),
                  Option("--standard-dh", &c.standard_dh_file,
                         "Standard DH table (CSV), where the arm has one", {.file = FileUse::Written}),
                  Option("--robodk", &c.robodk_file, "The modified table in RoboDK's order of columns (CSV)",
                         {.file = FileUse::Written})},
      .run = [command] { return run_robot_export(*command); },
      .examples = {{"robot export kr210_r2700_2 --dh table.csv --urdf arm.urdf"}}};
}

}  // namespace truepose::tools
