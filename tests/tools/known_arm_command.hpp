#pragma once

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <boost/json/object.hpp>
#include <cstdint>
#include <string>
#include <vector>

#include "config/model_file.hpp"
#include "config/robot_file.hpp"
#include "core/math/random.hpp"
#include "tests/process.hpp"
#include "tests/temp_folder.hpp"
#include "tests/tools/known_model.hpp"
#include "tests/tools/printed_document.hpp"
#include "tests/tools/robot_file.hpp"

namespace truepose {

/// Commands on an arm whose truth is known, and readings of it with noise.
class KnownArmCommand : public testing::Test {
 protected:
  explicit KnownArmCommand(std::uint64_t seed) : random_{seed} {}

  Finished run(const std::string& command, std::vector<std::string> arguments) const {
    arguments.insert(arguments.begin(), {command, "--robot", kRobot, "--model", model_file_});
    return run_program("truepose", arguments);
  }
  boost::json::object document(const std::string& command, std::vector<std::string> arguments) const {
    arguments.push_back("--json");
    const Finished finished = run(command, arguments);
    EXPECT_EQ(finished.exit_code, 0) << finished.err;
    return finished.exit_code == 0 ? printed_document(finished.out).as_object() : boost::json::object{};
  }
  std::string path(const char* name) const { return folder_.path() / name; }

  Eigen::Vector3d noise(double sigma_mm = kNoise_mm) {
    const double x = random_.normal(), y = random_.normal(), z = random_.normal();
    return sigma_mm * Eigen::Vector3d(x, y, z);
  }

  static constexpr double kNoise_mm = 0.01;

  TempFolder folder_;
  Random random_;
  RobotModel nominal_ = config::load_robot(kRobot);
  config::ModelFile model_ = known_model(nominal_, kNoise_mm);
  std::string model_file_ = folder_.write("model.yaml", config::model_yaml(model_));
};

}  // namespace truepose
