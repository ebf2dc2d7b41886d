// Where a tool is on the flange, and a work frame in the robot's base.
#include <fmt/format.h>

#include <algorithm>
#include <boost/json.hpp>
#include <cmath>
#include <iostream>
#include <memory>
#include <numeric>

#include "config/text_file.hpp"
#include "core/formatted.hpp"
#include "core/identify/work_frame.hpp"
#include "core/math/angles.hpp"
#include "proto/krl/frame_data.hpp"
#include "tools/truepose/offline/arm_options.hpp"
#include "tools/truepose/offline/frame_options.hpp"
#include "tools/truepose/offline/offline_commands.hpp"
#include "tools/truepose/text.hpp"

namespace truepose::tools {
namespace {

namespace json = boost::json;
using config::ConfigError;

struct FrameCommand {
  ArmFiles arm;
  std::string data_file, out_file;
  NoiseOptions noise;
  int number = 1;
  std::vector<double> orientation;  ///< a,b,c
  FrameWords tool;
  bool as_json = false;
};

/// What was measured, to be told.
struct Told {
  std::string what;   ///< "tool"
  std::string table;  ///< "TOOL_DATA"
  int number;
  const FrameReadings& data;
  const MeasuredFrame& frame;
  Eigen::Isometry3d X;  ///< in the digits told
  std::vector<std::string> notes;

  std::string statement() const { return krl::frame_statement(table, number, X); }
};

Eigen::Matrix<double, 6, 1> sigmas_mm_deg(const MeasuredFrame& frame) {
  Eigen::Matrix<double, 6, 1> sigmas = frame.covariance.diagonal().cwiseSqrt();
  sigmas.tail<3>() *= kDegPerRad;
  return sigmas;
}

// ---- As text

Cells frame_cells(const Told& told) {
  const Eigen::Vector3d p = told.X.translation(), abc = kuka_abc_deg(told.X.linear());
  Cells cells{"mm, deg"};
  for (const double mm : p) cells.push_back(fmt::format("{:.4f}", mm));
  for (const double deg : abc) cells.push_back(fmt::format("{:.5f}", deg + 0.0));
  return cells;
}

Cells sigma_cells(const MeasuredFrame& frame) {
  const Eigen::Matrix<double, 6, 1> sigmas = sigmas_mm_deg(frame);
  Cells cells{"sigma"};
  for (Eigen::Index i = 0; i < 3; ++i) cells.push_back(fmt::format("{:.4f}", sigmas[i]));
  // Turns about the axes of the outer frame: those of A, B, C have no bound where B is near 90 deg.
  for (Eigen::Index i = 3; i < 6; ++i)
    cells.push_back(frame.is_orientation_known ? fmt::format("{:.5f}", sigmas[i]) : "-");
  return cells;
}

std::string readings_text(const Told& told) {
  const std::vector<double>& errors = told.frame.error_mm;
  std::vector<Cells> rows{{"row", "point", "off by, mm"}};
  for (std::size_t i = 0; i < errors.size(); ++i) {
    const FrameReading& reading = told.data.readings[i];
    rows.push_back({std::to_string(reading.row), told.data.points[reading.point].name,
                    fmt::format("{:.4f}", errors[i])});
  }
  return text_table(rows);
}

std::string scatter_text(const MeasuredFrame& frame) {
  if (!frame.sigma0)
    return "No reading is spare, so that nothing checks them: measure each point more than once.\n";
  const double rms = std::sqrt(
      std::inner_product(frame.error_mm.begin(), frame.error_mm.end(), frame.error_mm.begin(), 0.0) /
      static_cast<double>(frame.error_mm.size()));
  return fmt::format("Readings: {:.4f} mm (RMS) from where all together say, {:.1f} times their noise.\n",
                     rms, *frame.sigma0);
}

std::string misfit_text(const Told& told) {
  if (told.frame.misfit_mm.empty()) return {};
  std::string text = "Points from their stated coordinates, mm:";
  for (std::size_t i = 0; i < told.data.points.size(); ++i)
    text += fmt::format(" {} {:.4f}", told.data.points[i].name, told.frame.misfit_mm[i]);
  return text + "\n";
}

std::string text_of(const Told& told) {
  std::string text = fmt::format("{} {}: {} readings of {} points\n", told.what, told.number,
                                 told.data.readings.size(), told.data.points.size());
  text += text_table(std::vector<Column>{{-8}, {10, 1}, {10, 1}, {10, 1}, {11, 1}, {11, 1}, {11, 1}},
                     {{"", "X", "Y", "Z", "A", "B", "C"}, frame_cells(told), sigma_cells(told.frame)});
  text += "\n" + readings_text(told) + "\n" + scatter_text(told.frame) + misfit_text(told);
  for (const std::string& note : told.notes) text += note + "\n";
  return text + told.statement() + "\n";
}

// ---- As a document

json::object document_of(const Told& told) {
  const Eigen::Vector3d p = told.X.translation(), abc = kuka_abc_deg(told.X.linear());
  const Eigen::Matrix<double, 6, 1> s = sigmas_mm_deg(told.frame);
  const bool oriented = told.frame.is_orientation_known;
  json::array readings, points;
  for (std::size_t i = 0; i < told.data.readings.size(); ++i) {
    const FrameReading& reading = told.data.readings[i];
    readings.push_back(json::object{{"row", reading.row},
                                    {"point", told.data.points[reading.point].name},
                                    {"error_mm", told.frame.error_mm[i]}});
  }
  for (std::size_t i = 0; i < told.data.points.size(); ++i) {
    json::object point{{"name", told.data.points[i].name}};
    if (!told.frame.misfit_mm.empty()) point["misfit_mm"] = told.frame.misfit_mm[i];
    points.push_back(std::move(point));
  }
  return {
      {"number", told.number},
      {"frame", {{"x", p.x()}, {"y", p.y()}, {"z", p.z()}, {"a", abc.x()}, {"b", abc.y()}, {"c", abc.z()}}},
      {"sigma_mm", {s[0], s[1], s[2]}},
      {"sigma_deg", oriented ? json::value{s[3], s[4], s[5]} : json::value{}},
      {"sigma0", told.frame.sigma0 ? json::value(*told.frame.sigma0) : json::value{}},
      {"readings", std::move(readings)},
      {"points", std::move(points)},
      {"notes", json::value_from(told.notes)},
      {"krl", told.statement()}};
}

// ---- The commands

std::vector<std::string> notes_of(const MeasuringCell& by, const std::filesystem::path& model) {
  if (by.covariance.size() > 0) return {};
  return {model.string() +
          ": tells no covariance, so sigma is of the readings alone; calibrate again to have it"};
}

/// Tells it; the rows that the others contradict end the command before anything is written.
void tell(const Told& told, const FrameCommand& command) {
  if (command.as_json) {
    std::cout << document_of(told) << '\n';
  } else {
    std::cout << text_of(told);
  }
  if (told.frame.doubtful.empty()) return;
  std::string rows;
  for (const std::size_t i : told.frame.doubtful)
    rows += (rows.empty() ? "" : ", ") + std::to_string(told.data.readings[i].row);
  throw CommandError{kFailed,
                     command.data_file + ": row " + rows +
                         ": more than five standard deviations from where the other rows say; measure "
                         "again, or leave out what slipped"};
}

/// What a frame is found from.
struct FrameInput {
  /// @param of_arm  every reading tells the arm's joints
  FrameInput(const FrameCommand& command, bool of_arm)
      : nominal{config::load_robot(command.arm.robot)},
        model{load_model_of(nominal, command.arm.model)},
        by{measuring_cell_of(model, command.arm.model, noise_of(command.noise))},
        data{config::load_frame_readings(command.data_file, nominal, of_arm)} {}

  RobotModel nominal;
  config::ModelFile model;
  MeasuringCell by;
  FrameReadings data;
};

/// @return what is told of the frame, where it was found
Told told_of(const char* what, const char* table, const std::expected<MeasuredFrame, std::string>& frame,
             const FrameInput& given, const FrameCommand& command) {
  if (!frame) throw CommandError{kFailed, command.data_file + ": " + frame.error()};
  return {what,
          table,
          command.number,
          given.data,
          *frame,
          config::as_told(frame->X),
          notes_of(given.by, command.arm.model)};
}

int run_tool(const FrameCommand& command) {
  const FrameInput given{command, true};
  const std::vector<double>& abc = command.orientation;
  const Eigen::Matrix3d R_else =
      abc.empty() ? Eigen::Matrix3d::Identity()
                  : rotation_zyx(abc[0] * kRadPerDeg, abc[1] * kRadPerDeg, abc[2] * kRadPerDeg);
  const auto frame = tool_frame(given.data, given.by, R_else);
  Told told = told_of("tool", "TOOL_DATA", frame, given, command);
  if (!frame->is_orientation_known)
    told.notes.push_back("A, B, C were not measured, but taken as given (--orientation).");
  tell(told, command);
  if (!command.out_file.empty())
    config::write_text_file(command.out_file,
                            config::tool_yaml({command.number, given.nominal.name, told.X, given.data}));
  return kDone;
}

int run_base(const FrameCommand& command) {
  const FrameInput given{command, false};
  const auto tool = tool_of(command.tool, "--tool", given.nominal, given.model);
  const bool touched = !given.data.readings[0].p_WS_mm;
  if (touched && !tool)
    throw ConfigError(command.data_file +
                      ": has no columns x,y,z, so its points were touched: give the tool that did (--tool)");
  const TouchingTool tcp{tool ? Eigen::Vector3d(tool->X_FT.translation()) : Eigen::Vector3d(0, 0, 0),
                         tool && tool->measured ? &*tool->measured : nullptr};
  const auto frame = work_frame(given.data, given.by, tcp);
  Told told = told_of("base", "BASE_DATA", frame, given, command);
  if (touched && !tool->measured)
    told.notes.push_back(
        "The tool was given, not measured: what it is off by is in this frame, and not in sigma.");
  tell(told, command);
  if (!command.out_file.empty())
    config::write_text_file(command.out_file, config::base_yaml({command.number, given.nominal.name,
                                                                 given.model.created, told.X}));
  return kDone;
}

std::vector<Option> common_options(FrameCommand& c, const char* data_help, const char* number_help) {
  return {Option("--robot", &c.arm.robot, "Robot file (YAML)", {.required = true}),
          Option("--model", &c.arm.model, "Model file of the calibrated arm", {.required = true}),
          Option("--data", &c.data_file, data_help, {.required = true}),
          Option("--number", &c.number, number_help, {.shows_default = true, .check = in_range(1, 1000)}),
          tracker_noise_option(c.noise),
          repeatability_option(c.noise),
          Option("--out", &c.out_file, "Write it here (YAML), for the other commands and the daemon"),
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
      "the tool, where known)",
      "Number in TOOL_DATA");
  options.push_back(
      Option("--orientation", &c.orientation,
             "Orientation of the tool as a,b,c (deg), where the TCP alone is measured; otherwise the "
             "flange's",
             {.count = 3}));
  return {.name = "tool",
          .help = "Where a tool is on the flange of a calibrated arm, by a tracker or by touching one point",
          .options = std::move(options),
          .run = [command] { return run_tool(*command); }};
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
                           {.type = kFrameType}));
  return {.name = "base",
          .help = "Where a work frame is in the base of a calibrated arm",
          .options = std::move(options),
          .run = [command] { return run_base(*command); }};
}

}  // namespace truepose::tools
