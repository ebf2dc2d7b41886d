// How often a sound calibration is doubted, and how often one of bad data is not.
#include <gtest/gtest.h>

#include <functional>
#include <iostream>

#include "core/judge/calibration_doubts.hpp"
#include "core/math/angles.hpp"
#include "core/simulate/true_arm.hpp"
#include "tests/core/example_arms.hpp"
#include "tests/core/example_campaigns.hpp"

namespace truepose {
namespace {

constexpr MeasurementNoise kStated{.tracker = {.range_mm = 0.01, .transverse_mm_per_m = 0.003},
                                   .repeatability_mm = 0.0166};

/// A campaign as the daemon measures it: poses to identify with the reference among them, then those to
/// validate, and the reference once more.
struct MeasuredCampaign {
  struct Options {
    std::uint64_t seed = 0;
    int identify = 30, validate = 30;
    int reference_every = 10;
    NonGeometricErrors errors{};
    CalibrateOptions calibrate{};
    /// What happens before the point of this number.
    std::function<void(TrueArmSetup& truth, TrackerNoiseModel& noise, int point)> before{};
  };

  explicit MeasuredCampaign(const Options& options) : random{options.seed} {
    TrueArmSetup truth = example::true_arm(options.errors);
    truth.repeatability_mm = kStated.repeatability_mm;
    TrackerNoiseModel noise = kStated.tracker;
    TrueArm arm{truth, options.seed};
    const JointVector q_reference = (JointVector(6) << 0.1, -1.4, 1.5, 0.2, 0.5, -0.3).finished();
    data.smr_names = {"1"};
    const auto read = [&](const JointVector& q) {
      arm.move_to(q);
      const Eigen::Vector3d p_mm =
          arm.p_WS_mm(q) + (truth.X_WB.translation() - arm.setup().X_WB.translation());
      return noisy_reading(p_mm, noise, random);
    };
    const auto visit = [&] {
      if (options.reference_every > 0) reference_mm.push_back(read(q_reference));
    };
    for (int n = 0; n < options.identify + options.validate; ++n) {
      if (options.before) options.before(truth, noise, n);
      if (n <= options.identify && options.reference_every > 0 && n % options.reference_every == 0) visit();
      Measurement point;
      point.q = random_poses(example::kr210(), 1, random).front();
      point.p_WS_mm = read(point.q);
      point.set = n < options.identify ? PoseSet::Identify : PoseSet::Validate;
      point.direction = arm.directions();
      data.points.push_back(point);
    }
    visit();
    CalibrateOptions calibrate_options = options.calibrate;
    calibrate_options.check_model = false;
    calibrate_options.noise = kStated;
    auto made = calibrate(example::kr210(), data, calibrate_options);
    EXPECT_TRUE(made) << made.error().detail;
    if (made) calibration = *std::move(made);
  }

  std::vector<std::string> doubts() const {
    return calibration_doubts(
        {.calibration = calibration, .data = data, .reference_mm = reference_mm, .stated = kStated});
  }

  Random random;
  MeasurementData data;
  std::vector<Eigen::Vector3d> reference_mm;
  Calibration calibration;
};

/// In how many of so many seeded campaigns somebody would have to look.
int doubted(int runs, MeasuredCampaign::Options options) {
  int count = 0;
  for (int run = 0; run < runs; ++run) {
    options.seed = static_cast<std::uint64_t>(run) + 1;
    const auto doubts = MeasuredCampaign{options}.doubts();
    count += doubts.empty() ? 0 : 1;
    if (!doubts.empty()) std::cout << "seed " << options.seed << ": " << doubts.front() << '\n';
  }
  return count;
}

void bump(TrueArmSetup& truth, double way_mm) {
  truth.X_WB.translation() += way_mm * Eigen::Vector3d(0.6, 0, 0.8);
}

TEST(DoubtsOfASoundCampaign, AreRare) {
  EXPECT_LE(doubted(200, {}), 1);
  EXPECT_LE(doubted(100, {.identify = 16, .validate = 8}), 1);
  EXPECT_LE(doubted(100, {.identify = 10, .validate = 6}), 2);
}

TEST(DoubtsOfASoundCampaign, AreRareForAHeavyArmThatItsModelDescribesInPart) {
  // Gears, loads and play: a geometric model leaves tenths of a millimetre, which is no contradiction.
  EXPECT_LE(doubted(50, {.errors = heavy_arm_errors({.backlash_rad = 0.002 * kRadPerDeg})}), 1);
  EXPECT_LE(doubted(50, {.identify = 16, .validate = 8, .errors = heavy_arm_errors({})}), 2);
}

TEST(DoubtsOfABadCampaign, AreNeverMissing) {
  constexpr int kRuns = 20;
  const auto in_identify = [](TrueArmSetup& truth, TrackerNoiseModel&, int point) {
    if (point == 9) bump(truth, 5);
  };
  EXPECT_EQ(doubted(kRuns, {.identify = 19, .before = in_identify}), kRuns);
  EXPECT_EQ(doubted(kRuns, {.identify = 19, .reference_every = 0, .before = in_identify}), kRuns);
  const auto before_validation = [](TrueArmSetup& truth, TrackerNoiseModel&, int point) {
    if (point == 19) bump(truth, 2);
  };
  EXPECT_EQ(doubted(kRuns, {.identify = 19, .before = before_validation}), kRuns);
  EXPECT_EQ(doubted(kRuns, {.identify = 19, .reference_every = 0, .before = before_validation}), kRuns);
  const auto noisy = [](TrueArmSetup&, TrackerNoiseModel& noise, int) {
    noise.range_mm = noise.transverse_mm = 3;
  };
  EXPECT_EQ(doubted(kRuns, {.before = noisy}), kRuns);
  EXPECT_EQ(doubted(kRuns, {.reference_every = 0, .before = noisy}), kRuns);
  const auto sixth = [](TrueArmSetup&, TrackerNoiseModel& noise, int point) {
    noise.range_mm = noise.transverse_mm = point % 6 == 5 ? 3 : 0.01;
  };
  EXPECT_EQ(doubted(kRuns, {.before = sixth}), kRuns);
}

}  // namespace
}  // namespace truepose
