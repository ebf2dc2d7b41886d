// The robots that come with the program, and a first file for one that does not.
#include <cmath>
#include <cstdio>
#include <memory>

#include "config/robot_file.hpp"
#include "config/robot_library.hpp"
#include "config/robot_text.hpp"
#include "config/text_file.hpp"
#include "core/arm/forward.hpp"
#include "core/arm/joint_units.hpp"
#include "core/math/angles.hpp"
#include "tools/truepose/offline/offline_commands.hpp"
#include "tools/truepose/text.hpp"

namespace truepose::tools {
namespace {

int run_list() {
  const auto files = config::shipped_robot_files();
  if (files.empty())
    throw CommandError{kFailed,
                       "no folder share/truepose/robots next to the program. Install truepose whole."};
  std::vector<Cells> rows{{"NAME", "ARM", "JOINTS"}};
  for (const std::filesystem::path& file : files) {
    const RobotModel robot = config::load_robot(file);
    rows.push_back({file.stem().string(), robot.name, shown(robot.joint_count())});
  }
  std::fputs(text_table(rows).c_str(), stdout);
  return kDone;
}

std::string shown_number(double value) { return shown(value + 0.0, value == std::round(value) ? 0 : 3); }

int run_show(const std::filesystem::path& file_or_name) {
  const std::filesystem::path file = config::robot_file_of(file_or_name);
  const RobotModel robot = config::load_robot(file);
  std::printf("%s: %s\n", file.c_str(), robot.name.c_str());
  std::vector<Cells> rows{{"JOINT", "a", "alpha", "d", "theta", "beta", "sign", "min", "max", "speed", ""}};
  for (std::size_t i = 0; i < robot.joints.size(); ++i) {
    const Joint& joint = robot.joints[i];
    const double unit = unit_of(joint);
    rows.push_back({shown(static_cast<int>(i) + 1), shown_number(joint.a_mm),
                    shown_number(joint.alpha_rad * kDegPerRad), shown_number(joint.d_mm),
                    shown_number(joint.theta_rad * kDegPerRad), shown_number(joint.beta_rad * kDegPerRad),
                    shown_number(joint.sign), shown_number(joint.min / unit), shown_number(joint.max / unit),
                    shown_number(joint.speed / unit), joint.type == JointType::Prismatic ? "mm" : "deg"});
  }
  std::fputs(text_table(rows).c_str(), stdout);
  for (const JointCoupling& each : robot.coupling)
    std::printf("coupling %s\n", config::coupling_text(each).c_str());
  const Eigen::Vector3d p = robot.X_flange.translation(), abc = kuka_abc_deg(robot.X_flange.linear());
  std::printf("flange x %s, y %s, z %s mm, a %s, b %s, c %s deg\n", shown_number(p.x()).c_str(),
              shown_number(p.y()).c_str(), shown_number(p.z()).c_str(), shown_number(abc.x()).c_str(),
              shown_number(abc.y()).c_str(), shown_number(abc.z()).c_str());
  return kDone;
}

struct RobotTemplate {
  std::filesystem::path out;
  std::string name;
  int joints = 6;
};

int run_new(const RobotTemplate& command) {
  RobotModel robot;
  robot.name = command.name;
  robot.joints.assign(static_cast<std::size_t>(command.joints),
                      {.min = -180 * kRadPerDeg, .max = 180 * kRadPerDeg, .speed = 100 * kRadPerDeg});
  config::write_text_file(
      command.out,
      config::robot_text(
          robot,
          {"One line per joint, from base to flange, in modified DH (Craig):",
           "  Rot(y, beta) Rot(x, alpha) Trans(a, 0, 0) Rot(z, theta) Trans(0, 0, d), theta = sign * q + theta",
           "a and alpha lead from the axis before; mm and deg. q is what the controller shows.",
           "A standard DH table: truepose robot import table.csv --dh standard does not need this file.",
           "min, max, speed: of q, from the data sheet. Linear axis: type: prismatic in front.",
           "FANUC: coupling: [{joint: 3, to: 2, factor: 1}] at the level of flange.",
           "Compare with the pendant: truepose robot check FILE --joints J.csv --poses P.csv"}));
  std::printf("%s: written, with zeros. Enter the lengths and angles of the data sheet.\n",
              command.out.c_str());
  return kDone;
}

}  // namespace

Command robot_list_command() {
  return {
      .name = "robot list", .help = "The robots that come with truepose", .run = [] { return run_list(); }};
}

Command robot_show_command() {
  const auto robot = std::make_shared<std::filesystem::path>();
  return {.name = "robot show",
          .help = "The table of a robot: mm, deg, deg/s",
          .options = {Option("robot", robot.get(), "Robot file (YAML), or the name of a shipped one",
                             {.required = true, .type = "ROBOT", .file = FileUse::Read})},
          .run = [robot] { return run_show(*robot); },
          .examples = {{"robot show kr210_r2700_2"}}};
}

Command robot_new_command() {
  const auto command = std::make_shared<RobotTemplate>();
  RobotTemplate& c = *command;
  return {.name = "robot new",
          .help = "Writes a robot file with comments, to be filled in",
          .options = {Option("--name", &c.name, "Name of the arm", {.required = true}),
                      Option("--joints", &c.joints, "Number of joints",
                             {.shows_default = true, .check = in_range(1, kMaxJoints)}),
                      Option("--out", &c.out, "Robot file to write",
                             {.required = true, .file = FileUse::Written})},
          .run = [command] { return run_new(*command); },
          .examples = {{"robot new --name \"my arm\" -o arm.yaml"}}};
}

}  // namespace truepose::tools
