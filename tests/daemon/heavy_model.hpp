#pragma once

#include <cstdint>
#include <memory>

#include "core/field/gaussian_process.hpp"
#include "core/fit/regression_field.hpp"
#include "core/math/random.hpp"
#include "tests/daemon/stream_rig.hpp"

namespace truepose::daemon {

/// The real arm with all that a model can have beyond its geometry: deviations of every joint by gears and
/// gravity, and a residual field over 300 poses. The field's hyper-parameters are those of a tenth of them.
inline RobotModel heavy_arm(std::uint64_t seed = 9) {
  RobotModel robot = real_arm();
  for (int joint = 0; joint < robot.joint_count(); ++joint) {
    robot.masses.push_back({.mass_kg = 200.0 / (1 + joint), .centre_mm = {100, 0, 50}});
    for (const DeviationBasis basis : {DeviationBasis::Sine, DeviationBasis::Cosine, DeviationBasis::Gravity})
      robot.deviation.push_back({.joint = joint, .basis = basis, .order = 1, .coefficient = 1e-4});
  }
  constexpr int kPoses = 300;
  Random random{seed};
  RegressionData data{.X = Eigen::MatrixXd(kPoses, field_features(robot)), .Y = Eigen::MatrixXd(kPoses, 3)};
  for (double& x : data.X.reshaped()) x = random.uniform(-1, 1);
  for (double& y : data.Y.reshaped()) y = random.uniform(-0.05, 0.05);
  const RegressionData some{.X = data.X.topRows(kPoses / 10), .Y = data.Y.topRows(kPoses / 10)};
  const RegressorPtr regressor =
      kGaussianProcess.refit(fit_regressor(kGaussianProcess, some).value()->state().hyper, data);
  robot.field = std::make_shared<RegressionField>(robot, regressor, Eigen::Vector3d{60, -50, 190});
  return robot;
}

}  // namespace truepose::daemon
