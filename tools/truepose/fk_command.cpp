#include <CLI/CLI.hpp>
#include <boost/json.hpp>
#include <cstdio>
#include <iostream>
#include <memory>

#include "config/measurement_file.hpp"
#include "core/arm/forward.hpp"
#include "core/math/angles.hpp"
#include "tools/truepose/arm_files.hpp"
#include "tools/truepose/offline_commands.hpp"

namespace truepose::tools {

namespace {

namespace json = boost::json;

struct FkOptions {
  ArmFiles arm;
  std::string joints_file;
  bool as_json = false;
};

json::array row_major(const Eigen::Isometry3d& X) {
  json::array numbers;
  for (int i = 0; i < 16; ++i) numbers.emplace_back(X(i / 4, i % 4));
  return numbers;
}

void print_pose(const Eigen::Isometry3d& X) {
  const Eigen::Vector3d abc_deg = kuka_abc_deg(X.linear());
  std::printf("%.6f,%.6f,%.6f,%.8f,%.8f,%.8f\n", X(0, 3), X(1, 3), X(2, 3), abc_deg.x(), abc_deg.y(),
              abc_deg.z());
}

void run_fk(const FkOptions& options) {
  const RobotModel nominal = config::load_robot(options.arm.robot);
  const RobotModel robot =
      options.arm.model.empty() ? nominal : load_model_of(nominal, options.arm.model).cell.robot;
  const auto joints = config::load_joints(options.joints_file, nominal);
  if (!options.as_json) {
    std::puts("x,y,z,a,b,c");
    for (const JointVector& q : joints) print_pose(forward_kinematics(robot, q));
    return;
  }
  json::array poses;
  for (const JointVector& q : joints) poses.push_back(row_major(forward_kinematics(robot, q)));
  std::cout << json::object{{"poses", std::move(poses)}} << '\n';
}

}  // namespace

void add_fk_command(CLI::App& app) {
  const auto options = std::make_shared<FkOptions>();
  CLI::App* command = app.add_subcommand("fk", "Flange poses of joint positions, in the robot base frame");
  command->add_option("--robot", options->arm.robot, "Robot file (YAML)")->required();
  command->add_option("--model", options->arm.model,
                      "Model file of the calibrated arm; without it the nominal arm");
  command->add_option("--joints", options->joints_file, "Joint positions (CSV: q1..qN in deg or mm)")
      ->required();
  command->add_flag("--json", options->as_json, "One JSON document: 16 numbers a pose, row major, mm");
  command->callback([options] { run_fk(*options); });
}

}  // namespace truepose::tools
