#include <CLI/CLI.hpp>
#include <boost/json.hpp>
#include <iostream>
#include <memory>
#include <sstream>

#include "config/joint_columns.hpp"
#include "config/pose_files.hpp"
#include "config/text_file.hpp"
#include "core/compensation/pose_inverse.hpp"
#include "tools/truepose/arm_files.hpp"
#include "tools/truepose/compensate_program.hpp"
#include "tools/truepose/exit_code.hpp"
#include "tools/truepose/nominal_inverse.hpp"
#include "tools/truepose/offline_commands.hpp"
#include "tools/truepose/target_faults.hpp"

namespace truepose::tools {

namespace {

namespace json = boost::json;

struct CompensateOptions {
  ArmFiles arm;
  std::string joints_file, poses_file, out_file;
  ProgramOptions program;
  bool as_json = false;
};

using Targets = std::vector<PoseInverseResult>;

/// A target that cannot be reached.
struct Unreachable : std::runtime_error {
  Unreachable(const std::string& file, std::size_t index, const std::string& why)
      : std::runtime_error(file + ": row " + std::to_string(index + 1) + ": " + why) {}
};

Targets compensate_all_joints(const RobotModel& nominal, const RobotModel& calibrated,
                              const std::string& file) {
  Targets targets;
  for (const JointVector& q : config::load_joints(file, nominal)) {
    const auto result = compensate_joints(nominal, calibrated, q);
    if (!result) throw Unreachable(file, targets.size(), described(result.error()));
    targets.push_back(*result);
  }
  return targets;
}

Targets compensate_all_poses(const RobotModel& nominal, const RobotModel& calibrated,
                             const std::string& file) {
  NominalInverse inverse(nominal);
  Targets targets;
  for (const Eigen::Isometry3d& X_BF : config::load_poses(file)) {
    const auto q_nominal = inverse.next(X_BF);
    if (!q_nominal) throw Unreachable(file, targets.size(), q_nominal.error());
    const auto result = inverse_near(calibrated, X_BF, *q_nominal);
    if (!result) throw Unreachable(file, targets.size(), described(result.error()));
    targets.push_back(*result);
  }
  return targets;
}

json::object document(const RobotModel& robot, const Targets& targets) {
  json::array joints, residual_mm, iterations;
  for (const PoseInverseResult& target : targets) {
    json::array q;
    for (std::size_t i = 0; i < robot.joints.size(); ++i) {
      q.emplace_back(target.q[static_cast<Eigen::Index>(i)] / config::per_file_unit(robot.joints[i]));
    }
    joints.push_back(std::move(q));
    residual_mm.emplace_back(target.residual_mm);
    iterations.emplace_back(target.iterations);
  }
  return {{"joints", std::move(joints)},
          {"residual_mm", std::move(residual_mm)},
          {"iterations", std::move(iterations)}};
}

std::string csv(const RobotModel& robot, const Targets& targets) {
  std::vector<JointVector> joints;
  for (const PoseInverseResult& target : targets) joints.push_back(target.q);
  std::ostringstream text;
  config::write_joints(text, joints, robot);
  return text.str();
}

int run_compensate(const CompensateOptions& options) {
  const RobotModel nominal = config::load_robot(options.arm.robot);
  const RobotModel calibrated = load_model_of(nominal, options.arm.model).cell.robot;
  if (!options.program.src.empty()) {
    ProgramOptions program = options.program;
    program.robot = options.arm.robot;
    program.out_src = options.out_file;
    program.as_json = options.as_json;
    return run_compensate_program(program, nominal, calibrated);
  }
  const bool of_joints = !options.joints_file.empty();
  const std::string& file = of_joints ? options.joints_file : options.poses_file;
  const Targets targets = of_joints ? compensate_all_joints(nominal, calibrated, file)
                                    : compensate_all_poses(nominal, calibrated, file);
  for (std::size_t i = 0; i < targets.size(); ++i) {
    if (const std::string why = beyond_limits(nominal, targets[i].q); !why.empty())
      throw Unreachable(file, i, why);
  }

  if (!options.out_file.empty()) config::write_text_file(options.out_file, csv(nominal, targets));
  if (options.as_json) {
    std::cout << document(nominal, targets) << '\n';
  } else if (options.out_file.empty()) {
    std::cout << csv(nominal, targets);
  }
  return kDone;
}

}  // namespace

void add_compensate_command(CLI::App& app, int& exit_code) {
  const auto options = std::make_shared<CompensateOptions>();
  CLI::App* command =
      app.add_subcommand("compensate", "Joint positions at which the real arm stands where it should");
  command->add_option("--robot", options->arm.robot, "Robot file (YAML)")->required();
  command->add_option("--model", options->arm.model, "Model file of the calibrated arm")->required();
  CLI::Option_group* targets = command->add_option_group("targets", "What the real arm should reach");
  targets->add_option(
      "--joints", options->joints_file,
      "Joint positions (CSV: q1..qN in deg or mm): the real arm stands where the nominal arm would");
  targets->add_option(
      "--poses", options->poses_file,
      "Flange poses in the robot base frame (CSV: x,y,z in mm; a,b,c in deg). Each is reached on the "
      "branch nearest to the one before it, the first nearest to the middle of the joints' ranges");
  add_program_options(*command, *targets, options->program);
  targets->require_option(1);
  command->add_option("--out", options->out_file, "Write the joint positions (CSV) or the program here");
  command->add_flag("--json", options->as_json, "One JSON document");
  command->callback([options, &exit_code] {
    try {
      exit_code = run_compensate(*options);
    } catch (const Unreachable& error) {
      std::cerr << "truepose: " << error.what() << '\n';
      exit_code = kFailed;
    }
  });
}

}  // namespace truepose::tools
