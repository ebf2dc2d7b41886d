// Layers on arms of many kinds, with and without what they look for: what they may cost, and what they say of
// themselves.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <iostream>
#include <map>
#include <numbers>

#include "core/calibrate/calibrate.hpp"
#include "tests/core/example_arms.hpp"
#include "tests/core/example_campaigns.hpp"
#include "tests/trials.hpp"

namespace truepose {
namespace {

/// By how much the joints of an arm err, rad.
struct ErrorSizes {
  std::string name;
  double gears = 0, gravity = 0, play = 0;
};

const std::vector<ErrorSizes> kSizes{{"none"},
                                     {"gears 0.05 mrad", 0.05e-3},
                                     {"gears 0.2 mrad", 0.2e-3},
                                     {"gears 0.5 mrad", 0.5e-3},
                                     {"gravity 0.05 mrad", 0, 0.05e-3},
                                     {"gravity 0.5 mrad", 0, 0.5e-3},
                                     {"play 0.04 mrad", 0, 0, 0.04e-3},
                                     {"all", 0.15e-3, 0.3e-3, 0.03e-3}};

Eigen::Vector3d anywhere(Random& random, double within) {
  const double x = random.uniform(-within, within), y = random.uniform(-within, within);
  return {x, y, random.uniform(-within, within)};
}

/// Gears of random phases; masses off the links, on springs that give way by `gravity` at the most.
NonGeometricErrors errors_of(const RobotModel& arm, const ErrorSizes& sizes, Random& random) {
  NonGeometricErrors errors;
  for (int i = 0; i < arm.joint_count(); ++i) {
    errors.masses.push_back({random.uniform(5, 30), anywhere(random, 150)});
    DriveError& drive = errors.drives.emplace_back(DriveError{.backlash_rad = sizes.play});
    double share = 1;
    for (GearHarmonic& harmonic : drive.harmonics) {
      harmonic.amplitude_rad = share * sizes.gears * random.uniform(0.5, 1);
      harmonic.phase_rad = random.uniform(0, 2 * std::numbers::pi);
      share /= 3;
    }
  }
  JointVector largest = JointVector::Zero(arm.joint_count());
  for (const JointVector& q : random_poses(arm, 50, random))
    largest = largest.cwiseMax(gravity_torque_Nm(arm, errors, q).cwiseAbs());
  for (int i = 0; i < arm.joint_count(); ++i)
    if (largest[i] > 1)
      errors.drives[static_cast<std::size_t>(i)].compliance_rad_per_Nm = sizes.gravity / largest[i];
  return errors;
}

/// An arm and what was measured of it.
struct Study {
  RobotModel nominal;
  std::string errors;
  SimulatedCampaign campaign;

  double miss_mm(const CalibrateOptions& options) const {
    return example::mean_miss(calibrate(nominal, campaign.data, options), campaign);
  }
};

/// Poses in a quarter of the range of every joint, anywhere in it.
std::vector<JointVector> poses_of_a_quarter(RobotModel arm, int count, Random& random) {
  for (Joint& joint : arm.joints) {
    joint.min = std::max(joint.min, -std::numbers::pi);
    joint.max = std::min(joint.max, std::numbers::pi);
    const double quarter = (joint.max - joint.min) / 4;
    joint.min += random.uniform(0, 3 * quarter);
    joint.max = joint.min + quarter;
  }
  std::vector<JointVector> poses;
  for (int k = 0; k < count; ++k) poses.push_back(example::random_joints(arm, random));
  return poses;
}

Study study_of(std::uint64_t seed, const ErrorSizes& sizes, bool of_a_quarter) {
  Random random{seed};
  const std::array arms{example::kr210(), example::ur10(), example::lr_mate(), example::seven_axis()};
  Study study{.nominal = arms[random.next() % arms.size()], .errors = sizes.name};
  TrueArmSetup setup{.robot = example::deviating(study.nominal, random, 0.5, 1e-3),
                     .p_FS_mm = {80, 40, 120},
                     .repeatability_mm = kRepeatability_mm};
  setup.non_geometric = errors_of(study.nominal, sizes, random);
  setup.X_WB.translation() = Eigen::Vector3d{4000, 500, -300};
  const int poses = of_a_quarter ? 60 : 25 + static_cast<int>(random.next() % 60);
  const std::vector<JointVector> identify = of_a_quarter ? poses_of_a_quarter(study.nominal, poses, random)
                                                         : random_poses(study.nominal, poses, random);
  study.campaign = measure_campaign(setup, identify, random_poses(study.nominal, 60, random), {.seed = seed});
  return study;
}

/// Misses of one kind of errors, summed.
struct Misses {
  double nominal = 0, plain = 0, layered = 0;
  int worse = 0, trials = 0;
};

std::map<std::string, Misses> misses_over(int count, bool of_a_quarter) {
  std::map<std::string, Misses> misses;
  for (int trial = 0; trial < count; ++trial) {
    const ErrorSizes& sizes = kSizes[static_cast<std::size_t>(trial) % kSizes.size()];
    const Study study = study_of(static_cast<std::uint64_t>(1000 + trial), sizes, of_a_quarter);
    const auto plain = calibrate(study.nominal, study.campaign.data);
    EXPECT_TRUE(plain) << "seed " << 1000 + trial << ": " << plain.error().detail;
    if (!plain) continue;
    const double plain_mm = example::mean_miss(plain->cell, study.campaign);
    const double layered_mm = study.miss_mm({.non_geometric = true, .field = FieldUse::Auto});
    for (const std::string& name : {sizes.name, std::string{"together"}}) {
      Misses& sum = misses[name];
      sum.nominal += example::mean_miss(plain->coarse, study.campaign);
      sum.plain += plain_mm;
      sum.layered += layered_mm;
      sum.worse += layered_mm > 1.05 * plain_mm;
      ++sum.trials;
    }
  }
  for (const auto& [name, sum] : misses)
    std::cout << name << ": " << sum.trials << " arms, nominal " << sum.nominal / sum.trials << ", without "
              << sum.plain / sum.trials << ", with " << sum.layered / sum.trials << " mm, " << sum.worse
              << " worse than 1.05\n";
  return misses;
}

TEST(LayersOfAnyArm, AreNoWorseThanNoneAndRemoveWhatIsThere) {
  std::cout << "seeds from 1000\n";
  for (const auto& [name, sum] : misses_over(trials(400), false)) {
    EXPECT_LT(sum.layered, 1.05 * sum.plain) << name;
    EXPECT_LE(sum.worse, widened(0.02, 0.1) * sum.trials) << name;
  }
}

TEST(LayersOfAnyArm, FittedToAQuarterOfEachJointsRangeAreSafeInTheRest) {
  std::cout << "seeds from 1000\n";
  for (const auto& [name, sum] : misses_over(trials(400), true)) {
    EXPECT_LT(sum.plain, sum.nominal) << name;
    EXPECT_LT(sum.layered, 1.05 * sum.plain) << name;
  }
}

/// How many of the predicted coordinates of unmeasured poses lie within their 95 % interval.
struct Held {
  int within = 0, all = 0;

  double share() const { return static_cast<double>(within) / all; }
  void count(const Calibration& calibration, const SimulatedCampaign& campaign) {
    for (std::size_t i = 0; i < campaign.data.points.size(); ++i) {
      const Measurement& m = campaign.data.points[i];
      if (m.set != PoseSet::Validate) continue;
      const Eigen::Vector3d off = calibration.cell.predict(m) - campaign.p_true_mm[i];
      const Eigen::Matrix3d covariance = calibration.position_covariance(m.q, 0, m.direction);
      for (int k = 0; k < 3; ++k) within += std::abs(off[k]) < 1.96 * std::sqrt(covariance(k, k));
      all += 3;
    }
  }
};

TEST(ResidualField, IsKnownAsWellAsItsIntervalsSay) {
  // All that is not geometry is left to the field.
  std::cout << "seeds from 3000\n";
  Held held;
  for (int trial = 0; trial < trials(200); ++trial) {
    const ErrorSizes& sizes = kSizes[std::array{2U, 3U, 5U, 7U}[static_cast<std::size_t>(trial) % 4]];
    const Study study = study_of(static_cast<std::uint64_t>(3000 + trial), sizes, false);
    const auto fit = calibrate(study.nominal, study.campaign.data, {.field = FieldUse::Auto});
    ASSERT_TRUE(fit) << fit.error().detail;
    if (fit->cell.robot.field) held.count(*fit, study.campaign);
  }
  std::cout << held.within << " of " << held.all << " coordinates within\n";
  EXPECT_GT(held.within, widened(0.93, -0.02) * held.all);
  EXPECT_LT(held.within, widened(0.97, 0.01) * held.all);
}

TEST(LayersOfAnyArm, AreKnownAsWellAsTheIntervalsSayAfterTheirSelection) {
  struct Choice {
    std::string name;
    CalibrateOptions options;
  };
  const MeasurementNoise noise{.tracker = {.range_mm = kTrackerNoise_mm, .transverse_mm = kTrackerNoise_mm},
                               .repeatability_mm = kRepeatability_mm};
  const std::vector<Choice> choices{
      {"geometry", {.noise = noise}},
      {"deviations", {.noise = noise, .non_geometric = true}},
      {"field", {.noise = noise, .field = FieldUse::Auto}},
      {"both", {.noise = noise, .non_geometric = true, .field = FieldUse::Auto}}};
  std::cout << "seeds from 5000\n";
  for (const Choice& choice : choices) {
    Held held;
    std::map<std::string, Held> by_errors;
    for (int trial = 0; trial < trials(400); ++trial) {
      const ErrorSizes& sizes = kSizes[static_cast<std::size_t>(trial) % kSizes.size()];
      const Study study = study_of(static_cast<std::uint64_t>(5000 + trial), sizes, false);
      const auto fit = calibrate(study.nominal, study.campaign.data, choice.options);
      ASSERT_TRUE(fit) << fit.error().detail;
      held.count(*fit, study.campaign);
      by_errors[sizes.name].count(*fit, study.campaign);
    }
    for (const auto& [name, part] : by_errors)
      std::cout << choice.name << ", " << name << ": " << part.share() << '\n';
    std::cout << choice.name << ": " << held.share() << " of the coordinates within\n";
    EXPECT_GT(held.share(), widened(0.93, -0.02)) << choice.name;
    EXPECT_LT(held.share(), widened(0.97, 0.01)) << choice.name;
  }
}

TEST(ResidualField, SaysThatItKnowsLittleWhereNothingWasMeasured) {
  const Study study = study_of(3003, kSizes[3], true);
  const auto with = calibrate(study.nominal, study.campaign.data, {.field = FieldUse::Always});
  ASSERT_TRUE(with);
  const auto variance_at = [&](const JointVector& q) {
    return field_covariance(with->cell, q, with->cell.reflectors[0].p_FS_mm).trace();
  };
  double measured = 0, elsewhere = 0;
  for (const Measurement& m : study.campaign.data.points)
    (m.set == PoseSet::Identify ? measured : elsewhere) += variance_at(m.q) / 60;
  EXPECT_LT(measured, 0.5 * elsewhere);
}

}  // namespace
}  // namespace truepose
