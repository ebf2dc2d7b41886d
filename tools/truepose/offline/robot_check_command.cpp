// A robot file against what the pendant shows, before anything is measured.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <memory>
#include <numbers>

#include "config/measurement_file.hpp"
#include "config/robot_file.hpp"
#include "config/table/csv_reader.hpp"
#include "core/arm/pose_check.hpp"
#include "core/formatted.hpp"
#include "core/math/angles.hpp"
#include "tools/truepose/offline/offline_commands.hpp"
#include "tools/truepose/text.hpp"

namespace truepose::tools {
namespace {

struct RobotCheck {
  std::string robot_file, joints_file, poses_file;
  double tolerance_mm = 0.5, tolerance_deg = 0.05;
};

/// X Y Z A B C as a KUKA pendant shows them, in small or capital letters.
std::vector<Eigen::Isometry3d> load_pendant_poses(const std::string& file) {
  const config::CsvTable table = config::CsvTable::read(file);
  const bool capitals = table.has("X");
  std::vector<std::string> names;
  for (const char c : std::string{"XYZABC"})
    names.emplace_back(1, capitals ? c : static_cast<char>(c - 'A' + 'a'));
  table.expect_only(names);
  std::vector<Eigen::Isometry3d> poses;
  for (std::size_t row = 0; row < table.row_count(); ++row) {
    const auto number = [&](std::size_t i) { return table.number(row, table.column(names[i])); };
    poses.push_back(pose_from_kuka({number(0), number(1), number(2)}, {number(3), number(4), number(5)}));
  }
  return poses;
}

std::vector<PoseReading> readings_of(const RobotCheck& command, const RobotModel& robot) {
  const auto joints = config::load_joints(command.joints_file, robot);
  const auto poses = load_pendant_poses(command.poses_file);
  if (joints.size() != poses.size())
    throw CommandError{kBadInput, command.joints_file + " has " + std::to_string(joints.size()) + " rows, " +
                                      command.poses_file + " " + std::to_string(poses.size()) +
                                      ". Write the joints and the pose of each position into the same row."};
  std::vector<PoseReading> readings;
  for (std::size_t i = 0; i < joints.size(); ++i) readings.push_back({joints[i], poses[i]});
  return readings;
}

void add(std::string& text, const char* key, double change, const char* unit) {
  if (std::abs(change) < 5e-4) return;
  text += formatted("%s%s %+.3f %s", text.empty() ? "" : ", ", key, change, unit);
}

std::string pose_change(const Eigen::Isometry3d& X) {
  const Eigen::Vector3d p = X.translation(), abc = kuka_abc_deg(X.linear());
  std::string text;
  add(text, "x", p.x(), "mm");
  add(text, "y", p.y(), "mm");
  add(text, "z", p.z(), "mm");
  add(text, "a", abc.x(), "deg");
  add(text, "b", abc.y(), "deg");
  add(text, "c", abc.z(), "deg");
  return text;
}

std::string row_change(const Joint& from, const Joint& to) {
  std::string text = from.sign == to.sign ? "" : formatted("sign %.0f", to.sign);
  add(text, "a", to.a_mm - from.a_mm, "mm");
  add(text, "alpha", (to.alpha_rad - from.alpha_rad) * kDegPerRad, "deg");
  add(text, "d", to.d_mm - from.d_mm, "mm");
  add(text, "theta", std::remainder(to.theta_rad - from.theta_rad, 2 * std::numbers::pi) * kDegPerRad, "deg");
  return text;
}

std::string in_words(const PoseExplanation& e, const RobotModel& robot) {
  const std::string number = std::to_string(e.joint + 1);
  switch (e.place) {
    case PoseExplanation::Place::Coupling:
      return formatted("the coupling: joint %d to joint %d, factor %+.0f", e.joint + 1, e.joint,
                       e.fixed.coupling.back().factor);
    case PoseExplanation::Place::Flange:
      return "flange: " + pose_change(inverse_of(robot.X_flange) * e.fixed.X_flange) +
             " (or the pendant's tool is not zero)";
    case PoseExplanation::Place::Base:
      return "base: " + pose_change(e.X_base) + " (or the pendant's base is not zero)";
    case PoseExplanation::Place::Row:
      break;
  }
  const auto i = static_cast<std::size_t>(e.joint);
  return "row " + number + ": " + row_change(robot.joints[i], e.fixed.joints[i]);
}

/// The changes that explain the readings, or that none does.
std::string cause(const RobotCheck& command, const RobotModel& robot, std::span<const PoseReading> readings) {
  const double most_mm = std::max(command.tolerance_mm, 1000 * command.tolerance_deg * kRadPerDeg);
  std::string changes, nearest;
  for (const PoseExplanation& e : explain_differences(robot, readings)) {
    const std::string change = formatted("%s (leaves %.3f mm)", in_words(e, robot).c_str(), e.rms_mm);
    if (e.rms_mm <= most_mm) changes += (changes.empty() ? "change " : "; or change ") + change;
    if (nearest.empty()) nearest = " Nearest: " + change + ".";
  }
  if (!changes.empty()) return changes;
  return "no single row explains it. Check signs and zeros of all joints, and that tool and base are zero." +
         nearest;
}

int run_check(const RobotCheck& command) {
  const RobotModel robot = config::load_robot(command.robot_file);
  const std::vector<PoseReading> readings = readings_of(command, robot);
  const std::vector<PoseDifference> differences = differences_of(robot, readings);
  std::vector<Cells> rows{{"POSE", "mm", "deg"}};
  for (std::size_t i = 0; i < differences.size(); ++i)
    rows.push_back(
        {std::to_string(i + 1), shown(differences[i].mm, 3), shown(differences[i].rad * kDegPerRad, 4)});
  std::fputs(text_table(rows).c_str(), stdout);
  const double mm = std::ranges::max(differences, {}, &PoseDifference::mm).mm;
  const double deg = std::ranges::max(differences, {}, &PoseDifference::rad).rad * kDegPerRad;
  std::printf("largest difference %.3f mm, %.4f deg (limits %g mm, %g deg)\n", mm, deg, command.tolerance_mm,
              command.tolerance_deg);
  if (mm <= command.tolerance_mm && deg <= command.tolerance_deg) return kDone;
  throw CommandError{kFailed,
                     command.robot_file + ": does not fit the pendant: " + cause(command, robot, readings)};
}

}  // namespace

Command robot_check_command() {
  const auto command = std::make_shared<RobotCheck>();
  RobotCheck& c = *command;
  return {
      .name = "robot check",
      .help = "Compares a robot file with positions that the pendant shows, with tool and base at zero",
      .options = {Option("robot", &c.robot_file, "Robot file (YAML), or the name of a shipped one",
                         {.required = true, .type = "ROBOT", .file = FileUse::Read}),
                  Option("--joints", &c.joints_file, "Joint positions (CSV: q1..qN in deg or mm)",
                         {.required = true, .file = FileUse::Read}),
                  Option("--poses", &c.poses_file,
                         "The flange there (CSV: X,Y,Z in mm, A,B,C in deg), row by row",
                         {.required = true, .file = FileUse::Read}),
                  Option("--tolerance", &c.tolerance_mm, "Largest difference of a position in mm",
                         {.shows_default = true, .check = in_range(1e-6, 1000.0), .type = "MM"}),
                  Option("--tolerance-deg", &c.tolerance_deg, "Largest difference of an orientation in deg",
                         {.shows_default = true, .check = in_range(1e-6, 180.0), .type = "DEG"})},
      .run = [command] { return run_check(*command); },
      .examples = {{"robot check arm.yaml --joints joints.csv --poses poses.csv"}}};
}

}  // namespace truepose::tools
