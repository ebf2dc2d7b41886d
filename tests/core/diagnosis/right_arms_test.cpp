#include <gtest/gtest.h>

#include <array>

#include "core/calibrate/calibrate.hpp"
#include "core/diagnosis/model_sanity.hpp"
#include "core/math/units.hpp"
#include "tests/core/example_arms.hpp"
#include "tests/core/example_paths.hpp"
#include "tests/trials.hpp"

namespace truepose {
namespace {

/// Every length off by up to 3 mm, every angle by up to 15 mrad.
RobotModel as_badly_built(RobotModel robot, Random& random) {
  for (Joint& joint : robot.joints) {
    for (double* length : {&joint.a_mm, &joint.d_mm}) *length += random.uniform(-3, 3);
    for (double* angle : {&joint.alpha_rad, &joint.theta_rad, &joint.beta_rad})
      *angle += random.uniform(-0.015, 0.015);
  }
  return robot;
}

/// Random poses as often as those of a path.
std::vector<JointVector> some_poses(const RobotModel& robot, Random& random) {
  constexpr std::array kCounts{8, 10, 20, 30, 60};
  constexpr std::array kTurns_deg{0.0, 0.01, 0.1, 1.0, 5.0};
  const auto any_of = [&](const auto& values) { return values[random.next() % std::size(values)]; };
  const int count = any_of(kCounts);
  const double turn_rad = any_of(kTurns_deg) * kRadPerDeg;
  if (random.next() % 2 == 0) return example::along(robot, any_of(example::kPaths), count, turn_rad, random);
  std::vector<JointVector> poses;
  for (int k = 0; k < count; ++k) poses.push_back(example::random_joints(robot, random));
  return poses;
}

TEST(RightArms, AreNeverAccusedHoweverBadlyBuiltAndMeasured) {
  const std::array arms{example::kr210(), example::ur10(), example::seven_axis(), example::kr210_on_a_rail(),
                        example::scara()};
  const int cases = all_trials() ? 10000 : 100;
  for (int seed = 0; seed < cases; ++seed) {
    Random random{static_cast<std::uint64_t>(seed)};
    const RobotModel& nominal = arms[random.next() % arms.size()];
    const int reflectors = random.next() % 5 == 0 ? 3 : 1;
    const CalibratedCell truth = example::placed(as_badly_built(nominal, random), random, reflectors);
    const MeasurementData data =
        example::measured(truth, some_poses(nominal, random), example::kSigma_mm, random);
    if (const auto coarse = coarse_fit(nominal, data); !coarse) {
      EXPECT_EQ(coarse.error().fault, CalibrationFault::NotSeparable);
      continue;
    }
    const auto cause = diagnose_files(nominal, data);
    EXPECT_FALSE(cause) << nominal.name << ", seed " << seed << ": " << cause->sentence;
  }
}

}  // namespace
}  // namespace truepose
