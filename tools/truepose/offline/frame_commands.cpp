// Where a tool is on the flange, and a work frame in the robot's base.
#include <boost/json.hpp>
#include <iostream>
#include <memory>

#include "config/text_file.hpp"
#include "core/frames/tool_turn.hpp"
#include "core/frames/work_frame.hpp"
#include "core/math/angles.hpp"
#include "proto/control/json_text.hpp"
#include "proto/record/frame_document.hpp"
#include "tools/truepose/frame_text.hpp"
#include "tools/truepose/offline/arm_options.hpp"
#include "tools/truepose/offline/frame_options.hpp"
#include "tools/truepose/offline/offline_commands.hpp"
#include "tools/truepose/offline/table_options.hpp"
#include "tools/truepose/written_files.hpp"

namespace truepose::tools {
namespace {

using config::ConfigError;
using record::FrameDocument;

struct FrameCommand {
  ArmFiles arm;
  std::string data_file, out_file;
  TableOptions table;
  NoiseOptions noise;
  int number = 1;
  std::vector<double> orientation;  ///< a,b,c
  FrameWords tool;
  bool as_json = false;
};

/// Tells it; one that is not to be used ends the command before anything is written.
void print_document(const FrameDocument& document, const FrameCommand& command) {
  if (command.as_json) {
    std::cout << control::json_text(record::frame_document(document)) << '\n';
  } else {
    std::cout << frame_text(document);
  }
  if (const std::string why = record::why_not_usable(document); !why.empty())
    throw CommandError{kFailed, command.data_file + ": " + why};
}

/// What a frame is found from.
struct FrameInput {
  /// @param of_arm  every reading tells the arm's joints
  FrameInput(const FrameCommand& command, bool of_arm)
      : nominal{config::load_robot(command.arm.robot)},
        model{load_model_of(nominal, command.arm.model)},
        by{measuring_cell_of(model, command.arm.model, noise_of(command.noise))},
        data{read(command, nominal, of_arm)} {}

  RobotModel nominal;
  config::ModelFile model;
  MeasuringCell by;
  FrameReadings data;

 private:
  static FrameReadings read(const FrameCommand& command, const RobotModel& nominal, bool of_arm) {
    const config::TableReading reading = reading_of(command.table);
    return config::load_frame_readings(command.data_file, nominal, of_arm, &reading);
  }
};

/// @return the frame's document, if it was found
FrameDocument document_of(record::FrameKind kind, const std::expected<MeasuredFrame, std::string>& frame,
                          const FrameInput& given, const FrameCommand& command) {
  if (!frame) throw CommandError{kFailed, command.data_file + ": " + frame.error()};
  return record::frame_document_of(kind, command.number, given.data, *frame,
                                   config::rounded_for_controller(frame->X), given.by);
}

int run_tool(const FrameCommand& command) {
  FrameInput given{command, true};
  note_open_payload(given.model, command.arm.model);
  const std::vector<double>& abc = command.orientation;
  const Eigen::Matrix3d R_else =
      abc.empty() ? Eigen::Matrix3d::Identity()
                  : rotation_zyx(abc[0] * kRadPerDeg, abc[1] * kRadPerDeg, abc[2] * kRadPerDeg);
  if (!abc.empty()) given.data = without_orientations(std::move(given.data));
  const auto frame = tool_frame(given.data, given.by, R_else);
  const FrameDocument document = document_of(record::FrameKind::Tool, frame, given, command);
  print_document(document, command);
  if (!command.out_file.empty())
    config::write_text_file(
        command.out_file,
        config::tool_yaml({command.number, given.nominal.name, given.model.serial, document.X, given.data}));
  if (!command.as_json) note_written({command.out_file});
  return kDone;
}

int run_base(const FrameCommand& command) {
  const FrameInput given{command, false};
  const auto tool = tool_of(command.tool, "--tool", given.nominal, given.model);
  const bool touched = !given.data.readings[0].p_WS_mm;
  if (touched) note_open_payload(given.model, command.arm.model);
  if (touched && !tool)
    throw ConfigError(command.data_file +
                      ": has no columns x,y,z, so its points were touched: give the tool that did (--tool)");
  const TouchingTool tcp{tool ? Eigen::Vector3d(tool->X_FT.translation()) : Eigen::Vector3d(0, 0, 0),
                         tool && tool->measured ? &*tool->measured : nullptr};
  const auto frame = work_frame(given.data, given.by, tcp);
  FrameDocument document = document_of(record::FrameKind::Base, frame, given, command);
  if (touched && tool->number > 0) document.touched_by = tool->number;
  if (touched && !tool->measured)
    document.notes.push_back(
        "The tool was given, not measured: what it is off by is in this frame, and not in sigma.");
  print_document(document, command);
  if (!command.out_file.empty())
    config::write_text_file(command.out_file,
                            config::base_yaml({command.number, given.nominal.name, given.model.created,
                                               document.X, frame->covariance, given.data,
                                               touched ? std::optional{tcp.p_F_mm} : std::nullopt}));
  if (!command.as_json) note_written({command.out_file});
  return kDone;
}

std::vector<Option> common_options(FrameCommand& c, const char* data_help, const char* number_help) {
  return {
      Option("--robot", &c.arm.robot, "Robot file (YAML)",
             {.required = true, .place = "ROBOT", .file = FileUse::Read}),
      Option("--model", &c.arm.model, "Model file of the calibrated arm",
             {.required = true, .place = "MODEL", .file = FileUse::Read}),
      Option("--data", &c.data_file, data_help, {.required = true, .place = "DATA", .file = FileUse::Read}),
      Option("--number", &c.number, number_help, {.shows_default = true, .check = in_range(1, 1000)}),
      columns_option(c.table),
      units_option(c.table),
      tracker_noise_option(c.noise),
      repeatability_option(c.noise),
      Option("--out", &c.out_file, "Write it here (YAML), for the other commands and the daemon",
             {.file = FileUse::Written}),
      Option("--json", &c.as_json, "One JSON document")};
}

}  // namespace

Command tool_command() {
  const auto command = std::make_shared<FrameCommand>();
  FrameCommand& c = *command;
  std::vector<Option> options = common_options(
      c,
      "Readings (CSV: q1..qN in deg or mm; x,y,z in mm of a reflector at the tool; without them one fixed point, "
      "touched each time; point: origin, the TCP, as without it, x or xy; px,py,pz: the point's coordinates in "
      "the tool, where known; a,b,c,sigma_abc in deg: a 6-D target's axes in the tracker's frame, which are the "
      "tool's: one reading then gives the tool)",
      "Number in TOOL_DATA");
  options.push_back(
      Option("--orientation", &c.orientation,
             "Orientation of the tool as a,b,c (deg), in place of a 6-D target's or, where the TCP alone is "
             "measured, the flange's",
             {.type = "A,B,C", .count = 3}));
  return {.name = "tool",
          .help = "Where a tool is on the flange of a calibrated arm, by a tracker or by touching one point",
          .options = std::move(options),
          .run = [command] { return run_tool(*command); },
          .examples = {{"tool arm.yaml model.yaml tool.csv --number 3 -o gun.yaml",
                        "The tool of TOOL_DATA[3], for compensate and for the daemon"}}};
}

Command base_command() {
  const auto command = std::make_shared<FrameCommand>();
  FrameCommand& c = *command;
  std::vector<Option> options = common_options(
      c,
      "Readings (CSV: q1..qN in deg or mm where the TCP touched the point; or x,y,z in mm where the tracker read "
      "it; point: origin, x and xy, or any names with px,py,pz: coordinates in the frame)",
      "Number in BASE_DATA");
  options.push_back(Option("--tool", &c.tool,
                           "The tool that touched: a file of truepose tool, or its numbers",
                           {.type = kFrameType, .file = FileUse::Read}));
  return {.name = "base",
          .help = "Where a work frame is in the base of a calibrated arm",
          .options = std::move(options),
          .run = [command] { return run_base(*command); },
          .examples = {{"base arm.yaml model.yaml base.csv --number 5 -o fixture.yaml",
                        "The frame of BASE_DATA[5], by points that the tracker read"},
                       {"base arm.yaml model.yaml touched.csv --tool gun.yaml",
                        "The same by points that the TCP touched"}}};
}

}  // namespace truepose::tools
