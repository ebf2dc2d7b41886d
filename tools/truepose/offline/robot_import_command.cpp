// An arm from a file of another program, as a robot file.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <memory>

#include "config/import/dh_table.hpp"
#include "config/import/machine_data.hpp"
#include "config/import/opw_file.hpp"
#include "config/import/urdf_file.hpp"
#include "config/number_text.hpp"
#include "config/text_file.hpp"
#include "core/arm/forward.hpp"
#include "core/arm/joint_units.hpp"
#include "core/formatted.hpp"
#include "core/math/angles.hpp"
#include "tools/truepose/offline/imported_robot.hpp"
#include "tools/truepose/offline/offline_commands.hpp"

namespace truepose::tools {
namespace {

struct RobotImport {
  std::filesystem::path source, out;
  std::string name, dh, units;
  config::UrdfOptions urdf;
  std::vector<std::string> arguments;  // NAME=VALUE
  std::vector<double> coupling;        // JOINT, TO, FACTOR
};

config::ImportedArm from_table(const RobotImport& command) {
  if (command.dh.empty())
    throw CommandError{kBadInput,
                       command.source.string() +
                           ": which convention has this table? Give --dh standard (a and alpha behind "
                           "the joint) or --dh modified (in front of it, Craig)"};
  const auto units = config::dh_units(command.units);
  if (!command.units.empty() && !units)
    throw bad_usage("--units: expected a length and an angle such as mm,deg or m,rad");
  return config::load_dh_table(
      command.source,
      command.dh == "standard" ? config::DhConvention::Standard : config::DhConvention::Modified, units);
}

config::UrdfOptions urdf_options(const RobotImport& command) {
  config::UrdfOptions options = command.urdf;
  for (const std::string& each : command.arguments) {
    const std::size_t equals = each.find('=');
    if (equals == std::string::npos || equals == 0)
      throw bad_usage("--arg: expected NAME=VALUE, found '" + each + "'");
    options.arguments.insert_or_assign(each.substr(0, equals), each.substr(equals + 1));
  }
  return options;
}

/// Refuses options that say nothing of such a source.
void expect_options_of(const RobotImport& command, bool is_urdf, bool is_table) {
  const config::UrdfOptions& urdf = command.urdf;
  const bool has_urdf =
      !urdf.base.empty() || !urdf.tip.empty() || urdf.takes_masses || !command.arguments.empty();
  if (has_urdf && !is_urdf)
    throw bad_usage("--base, --tip, --arg, --masses: are of a .urdf or .xacro, and " +
                    command.source.string() + " is none");
  if (!is_table && (!command.dh.empty() || !command.units.empty()))
    throw bad_usage("--dh, --units: are of a DH table (.csv), and " + command.source.string() + " is none");
}

config::ImportedArm imported(const RobotImport& command) {
  std::string name = command.source.filename().string();
  std::ranges::transform(name, name.begin(), [](unsigned char c) { return std::tolower(c); });
  const bool is_urdf = name.ends_with(".urdf") || name.ends_with(".xacro"), is_table = name.ends_with(".csv");
  expect_options_of(command, is_urdf, is_table);
  if (is_urdf) return config::load_urdf(command.source, urdf_options(command));
  if (is_table) return from_table(command);
  if (name.ends_with(".yaml") || name.ends_with(".yml")) return config::load_opw(command.source);
  if (has_machine_data(command.source)) return {config::load_machine_data(command.source), {}};
  throw CommandError{kBadInput,
                     command.source.string() +
                         ": not a kind of file that can be imported. Give a KUKA archive (folder or .zip) or "
                         "$machine.dat, a .urdf or .xacro, a DH table (.csv) or OPW parameters (.yaml)."};
}

/// Refuses numbers that no arm has, as a wrong unit of the source makes them.
void expect_plausible(const RobotImport& command, const RobotModel& robot) {
  constexpr double kLongest_mm = 20'000, kMostTurn_deg = 720, kMostTravel_deg = 3600;
  for (std::size_t i = 0; i < robot.joints.size(); ++i) {
    const Joint& joint = robot.joints[i];
    const auto expect = [&](const char* what, double value, double most, const char* unit) {
      if (std::abs(value) <= most) return;
      throw config::ConfigError{command.source.string() + ": joint " + std::to_string(i + 1) + ": " + what +
                                formatted(" is %.0f %s (limit %.0f). Correct the unit in the source%s.",
                                          value, unit, most, command.dh.empty() ? "" : ", or --units")};
    };
    expect("a", joint.a_mm, kLongest_mm, "mm");
    expect("d", joint.d_mm, kLongest_mm, "mm");
    expect("alpha", joint.alpha_rad * kDegPerRad, kMostTurn_deg, "deg");
    expect("theta", joint.theta_rad * kDegPerRad, kMostTurn_deg, "deg");
    if (joint.type != JointType::Revolute) continue;
    expect("min", joint.min * kDegPerRad, kMostTravel_deg, "deg");
    expect("max", joint.max * kDegPerRad, kMostTravel_deg, "deg");
  }
}

/// The controller's coupling, which descriptions of the links do not have.
void couple(const std::vector<double>& numbers, RobotModel& robot) {
  if (numbers.empty()) return;
  const JointCoupling coupling{static_cast<int>(numbers[0]) - 1, static_cast<int>(numbers[1]) - 1,
                               numbers[2]};
  if (coupling.to < 0 || coupling.joint <= coupling.to || coupling.joint >= robot.joint_count())
    throw bad_usage("--coupling: expected a joint, one before it, and a factor: 3,2,1");
  robot.coupling.push_back(coupling);
}

/// FANUC's controllers count joint 3 from the horizon, which descriptions of the links do not say.
void warn_of_coupling(const RobotImport& command, config::ImportedArm& arm) {
  std::string named = arm.robot.name + command.source.string();
  std::ranges::transform(named, named.begin(), [](unsigned char c) { return std::tolower(c); });
  if (!command.coupling.empty() || !named.contains("fanuc")) return;
  arm.notes.push_back(
      "FANUC: joint 3 of the controller moves with joint 2, and here it does not: give --coupling 3,2,1");
}

/// Three positions to compare with the pendant: near zero, and every joint away from it to either side.
std::vector<JointVector> positions_to_compare(const RobotModel& robot) {
  std::vector<JointVector> positions;
  for (const double away : {0.0, 0.4, -0.3}) {
    JointVector q(robot.joint_count());
    for (int i = 0; i < robot.joint_count(); ++i) {
      const Joint& joint = robot.joints[static_cast<std::size_t>(i)];
      const double unit = unit_of(joint), zero = std::clamp(0.0, joint.min, joint.max);
      const double room = std::min(away < 0 ? zero - joint.min : joint.max - zero, 90 * unit);
      // At the end of its travel a joint moves to the other side.
      const double step = room > 10 * unit ? away * room : -away * std::min(joint.max - joint.min, 90 * unit);
      const double turned =
          zero + (zero == 0 || room > 10 * unit ? step : std::copysign(step, zero == joint.min ? 1 : -1));
      q[i] = std::round(std::clamp(turned, joint.min, joint.max) / unit) * unit;
    }
    positions.push_back(q);
  }
  return positions;
}

/// As it is printed: a zero has no sign.
double printed(double value) { return std::round(value * 1e4) / 1e4 + 0.0; }

void print_positions(const RobotModel& robot) {
  std::printf("Compare with the pendant (base and tool zero):\n");
  for (const JointVector& q : positions_to_compare(robot)) {
    std::string joints;
    for (const double each : in_deg_mm(q, robot))
      joints += formatted(joints.empty() ? "%.0f" : ", %.0f", each + 0.0);
    const Eigen::Isometry3d X = forward_kinematics(robot, q);
    const Eigen::Vector3d p = X.translation(), abc = kuka_abc_deg(X.linear());
    std::printf("  q %s: x %.3f y %.3f z %.3f mm, a %.4f b %.4f c %.4f deg\n", joints.c_str(), printed(p.x()),
                printed(p.y()), printed(p.z()), printed(abc.x()), printed(abc.y()), printed(abc.z()));
  }
}

int run_import(const RobotImport& command) {
  config::ImportedArm arm = imported(command);
  if (!command.name.empty()) arm.robot.name = command.name;
  expect_plausible(command, arm.robot);
  couple(command.coupling, arm.robot);
  warn_of_coupling(command, arm);
  config::write_text_file(command.out, imported_robot_text(arm, command.source));
  for (const std::string& note : arm.notes) std::printf("%s\n", note.c_str());
  std::printf("%s: %s, %d joints, written\n", command.out.c_str(), arm.robot.name.c_str(),
              arm.robot.joint_count());
  print_positions(arm.robot);
  return kDone;
}

}  // namespace

Command robot_import_command() {
  const auto command = std::make_shared<RobotImport>();
  RobotImport& c = *command;
  return {
      .name = "robot import",
      .help = "Makes a robot file from a KUKA archive, a URDF or xacro, a DH table or OPW parameters",
      .options =
          {Option("source", &c.source,
                  "KUKA archive (folder, .zip) or $machine.dat; .urdf or .xacro; DH table (.csv); OPW "
                  "parameters (.yaml)",
                  {.required = true, .type = "SOURCE", .file = FileUse::Read}),
           Option("--out", &c.out, "Robot file to write", {.required = true, .file = FileUse::Written}),
           Option("--name", &c.name, "Name of the arm, in place of the source's"),
           Option("--base", &c.urdf.base, "URDF: link of the robot base; without it base, or the root"),
           Option("--tip", &c.urdf.tip, "URDF: link of the flange; without it tool0, or the only end"),
           Option("--arg", &c.arguments, "xacro: an argument", {.type = "NAME=VALUE", .repeats = true}),
           Option("--masses", &c.urdf.takes_masses,
                  "URDF: takes the masses of the links too, which many files only make up"),
           Option("--dh", &c.dh, "DH table: its convention", {.check = available({"standard", "modified"})}),
           Option("--units", &c.units, "DH table: of columns without a unit in their name",
                  {.type = "LENGTH,ANGLE"}),
           Option("--coupling", &c.coupling,
                  "Joint that another one moves too, and by which factor: FANUC's is 3,2,1",
                  {.type = "JOINT,TO,FACTOR", .count = 3})},
      .run = [command] { return run_import(*command); },
      .examples = {{"robot import archive.zip -o arm.yaml", "The arm of a KUKA archive"},
                   {"robot import table.csv --dh standard --units m,rad -o arm.yaml"}}};
}

}  // namespace truepose::tools
