// Where a positioner stands in the base of a calibrated arm, and the workpiece on it.
#include <boost/json.hpp>
#include <iostream>
#include <memory>

#include "config/positioner_file.hpp"
#include "config/text_file.hpp"
#include "core/formatted.hpp"
#include "core/frames/positioner.hpp"
#include "core/frames/tool_frame.hpp"
#include "core/math/angles.hpp"
#include "proto/control/json_text.hpp"
#include "proto/record/positioner_document.hpp"
#include "tools/truepose/frame_text.hpp"
#include "tools/truepose/offline/arm_options.hpp"
#include "tools/truepose/offline/frame_options.hpp"
#include "tools/truepose/offline/offline_commands.hpp"
#include "tools/truepose/offline/table_options.hpp"
#include "tools/truepose/text.hpp"
#include "tools/truepose/written_files.hpp"

namespace truepose::tools {
namespace {

using config::ConfigError;
using record::PositionerDocument;

struct PositionerCommand {
  ArmFiles arm, table;
  std::string data_file, out_file;
  TableOptions reading;
  std::vector<double> root;  ///< x,y,z,a,b,c
  int number = 2, base_number = 1;
  bool as_json = false;
};

/// Both as they are calibrated.
struct Calibrated {
  explicit Calibrated(const ArmFiles& files)
      : nominal{config::load_robot(files.robot)},
        model{load_model_of(nominal, files.model)},
        by{measuring_cell_of(model, files.model)} {}

  RobotModel nominal;
  config::ModelFile model;
  MeasuringCell by;
};

std::optional<Eigen::Isometry3d> given_root(const PositionerCommand& command) {
  const std::vector<double>& v = command.root;
  if (v.empty()) return std::nullopt;
  return pose_from_kuka({v[0], v[1], v[2]}, {v[3], v[4], v[5]});
}

std::string text_of(const PositionerDocument& document) {
  std::string text = formatted("Root of machine %d in the robot's base\n", document.number) +
                     pose_text(document.X_BR, document.sigma_mm, document.sigma_deg) + "\n";
  for (const PositionerDocument::Axis& axis : document.axes)
    text += formatted("Axis %d goes through (%.3f %.3f %.3f) along (%.6f %.6f %.6f).\n", axis.joint,
                      axis.p_mm.x(), axis.p_mm.y(), axis.p_mm.z(), axis.direction.x(), axis.direction.y(),
                      axis.direction.z());
  for (const PositionerDocument::Link& link : document.links)
    text += formatted("%s is %.4f %s, nominal %.4f, sigma %.4f.\n", link.name.c_str(), link.value,
                      link.unit.c_str(), link.nominal, link.sigma);
  for (const std::string& note : document.notes) text += note + "\n";
  text += document.krl + "\n";
  return document.workpiece ? text + "\nWorkpiece on the table, as the controller has the table\n" +
                                  tools::frame_text(*document.workpiece)
                            : text;
}

/// Tells it; one that is not to be used ends the command before anything is written.
void print_document(const PositionerDocument& document, const PositionerCommand& command) {
  if (command.as_json) {
    std::cout << control::json_text(record::positioner_document(document)) << '\n';
  } else {
    std::cout << text_of(document);
  }
  if (!document.workpiece) return;
  if (const std::string why = record::why_not_usable(*document.workpiece); !why.empty())
    throw CommandError{kFailed, command.data_file + ": " + why};
}

FrameReadings workpiece_readings(const PositionerCommand& command, const RobotModel& table) {
  const config::TableReading reading = reading_of(command.reading);
  FrameReadings data = config::load_frame_readings(command.data_file, table, true, &reading);
  if (!data.readings[0].p_WS_mm)
    throw ConfigError(command.data_file + ": has no columns x,y,z: the workpiece is measured by the tracker");
  return data;
}

/// Where the readings have the workpiece on the table.
MeasuredFrame workpiece_of(const PositionerCommand& command, const FrameReadings& data,
                           const MeasuringCell& table) {
  auto workpiece = tool_frame(data, table);
  if (!workpiece) throw CommandError{kFailed, command.data_file + ": " + workpiece.error()};
  if (!workpiece->is_orientation_known)
    throw CommandError{kFailed, command.data_file +
                                    ": the points say no frame: expected origin, x and xy, or at least three "
                                    "points that all have known coordinates"};
  return *std::move(workpiece);
}

int run_positioner(const PositionerCommand& command) {
  const Calibrated arm{command.arm}, table{command.table};
  if (!is_positioner(table.nominal))
    throw ConfigError(formatted("%s: has %d joints, a positioner one or two", command.table.robot.c_str(),
                                table.nominal.joint_count()));
  const auto X_given = given_root(command);
  const Eigen::Isometry3d X_near = X_given.value_or(Eigen::Isometry3d::Identity());
  const PositionerRoot root = positioner_root(arm.by, table.by, table.nominal, X_near);
  if (const std::string why = why_turned(root.X_BR, arm.nominal, table.nominal, X_given); !why.empty())
    throw CommandError{kFailed, command.table.robot.string() + ": " + why};
  const Eigen::Isometry3d X_controller = config::rounded_for_controller(root.X_BR);
  PositionerDocument document = record::positioner_document_of(command.number, root, X_controller, arm.by,
                                                               table.by, table.model.parameters, X_given);
  FrameReadings data;
  if (!command.data_file.empty()) {
    data = workpiece_readings(command, table.nominal);
    const MeasuredFrame frame =
        workpiece_frame(workpiece_of(command, data, table.by), arm.by, table.by, table.nominal, X_near);
    document.workpiece = record::frame_document_of(record::FrameKind::Base, command.base_number, data, frame,
                                                   config::rounded_for_controller(frame.X), table.by);
  }
  print_document(document, command);
  if (!command.out_file.empty())
    config::write_text_file(command.out_file,
                            config::positioner_yaml({command.number, arm.nominal.name, arm.model.created,
                                                     X_controller, table.model, data}));
  if (!command.as_json) note_written({command.out_file});
  return kDone;
}

}  // namespace

Command positioner_command() {
  const auto command = std::make_shared<PositionerCommand>();
  PositionerCommand& c = *command;
  return {
      .name = "positioner",
      .help =
          "Where a turntable or positioner stands in the base of a calibrated arm, and the workpiece on it",
      .options =
          {Option("--robot", &c.arm.robot, "Robot file of the arm (YAML)",
                  {.required = true, .place = "ROBOT", .file = FileUse::Read}),
           Option("--model", &c.arm.model, "Model file of the calibrated arm",
                  {.required = true, .place = "MODEL", .file = FileUse::Read}),
           Option("--positioner", &c.table.robot,
                  "Robot file of the positioner: one or two joints, the root its base, the table its flange",
                  {.required = true, .file = FileUse::Read}),
           Option(
               "--positioner-model", &c.table.model,
               "Its model file, by truepose calibrate from the station of the tracker that measured the arm",
               {.required = true, .file = FileUse::Read}),
           Option(
               "--root", &c.root,
               "ROOT as the controller has it, in the robot's base (mm, deg): what no reading of a turntable shows "
               "stays so, and a root far from it is reported",
               {.type = "X,Y,Z,A,B,C", .count = 6}),
           Option(
               "--data", &c.data_file,
               "Readings of the workpiece (CSV: q1[,q2] of the positioner in deg or mm; x,y,z in mm of a reflector "
               "on it; point: origin, x and xy, or any names with px,py,pz: coordinates in the workpiece)",
               {.file = FileUse::Read}),
           columns_option(c.reading), units_option(c.reading),
           Option("--number", &c.number, "Number in MACHINE_DEF",
                  {.shows_default = true, .check = in_range(1, 16)}),
           Option("--base-number", &c.base_number, "Number in BASE_DATA of the workpiece",
                  {.shows_default = true, .check = in_range(1, 1000)}),
           Option("--out", &c.out_file, "Write both here (YAML), for truepose compensate",
                  {.needs = {"--data"}, .file = FileUse::Written}),
           Option("--json", &c.as_json, "One JSON document")},
      .run = [command] { return run_positioner(*command); },
      .examples = {
          {"positioner arm.yaml model.yaml --positioner table.yaml --positioner-model table_model.yaml --root 1900,350,-150,25,0,0 --data workpiece.csv -o positioner.yaml"}}};
}

}  // namespace truepose::tools
