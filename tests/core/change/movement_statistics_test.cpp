// How often movement() detects a change while it was measured, names it and its moment, and how often it
// reports one where nothing changed.
#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <iostream>
#include <optional>
#include <utility>

#include "core/calibrate/calibrate.hpp"
#include "core/change/movement.hpp"
#include "core/math/angles.hpp"
#include "core/simulate/true_arm.hpp"
#include "tests/core/example_arms.hpp"
#include "tests/core/example_campaigns.hpp"
#include "tests/trials.hpp"

namespace truepose {
namespace {

constexpr MeasurementNoise kCampaignNoise{.tracker = {.range_mm = 0.01, .transverse_mm_per_m = 0.003},
                                          .repeatability_mm = 0.0166};

struct MovedCampaign {
  int poses = 60;
  NonGeometricErrors errors{};
  bool noise_stated = true;
  double noisier = 1;                 ///< the tracker, than stated
  std::optional<Change> change = {};  ///< nothing: nothing changes
  /// Makes the change by the share 0 to 1 of it.
  std::function<void(TrueArmSetup& truth, double share)> make = [](TrueArmSetup&, double) {};
  bool little_by_little = false;
  bool back = false;  ///< a third of the points later
};

/// Of so many campaigns.
struct Rates {
  int runs = 0, reported = 0, named = 0, listed = 0, at_moment = 0;
};

Rates rates(const char* row, const MovedCampaign& of) {
  Rates rates{.runs = trials(200)};
  for (int run = 0; run < rates.runs; ++run) {
    const std::uint64_t seed = static_cast<std::uint64_t>(run) + 1;
    Random random{seed};
    const std::size_t third = static_cast<std::size_t>(of.poses) / 3;
    const std::size_t moment = third + random.next() % third, again = of.back ? moment + third - 5 : 0;
    TrueArmSetup unmoved = example::true_arm(of.errors);
    unmoved.repeatability_mm = kCampaignNoise.repeatability_mm;
    TrueArm arm{unmoved, seed};
    TrackerNoiseModel noise = kCampaignNoise.tracker;
    noise.range_mm *= of.noisier;
    noise.transverse_mm_per_m *= of.noisier;
    MeasurementData data;
    data.smr_names = {"1"};
    for (std::size_t n = 0; n < static_cast<std::size_t>(of.poses); ++n) {
      const bool moved = n >= moment && (again == 0 || n < again);
      const double share =
          of.little_by_little ? static_cast<double>(n) / (of.poses - 1) : static_cast<double>(moved);
      TrueArmSetup now = unmoved;
      of.make(now, share);
      Measurement point;
      point.q = random_poses(example::kr210(), 1, random).front();
      point.set = n % 3 == 2 ? PoseSet::Validate : PoseSet::Identify;
      arm.move_to(point.q);
      // What repeats badly is the arm's as it was; what changed shifts the reading.
      const Eigen::Vector3d change_mm =
          TrueArm{now, seed}.p_WS_mm(point.q) - TrueArm{unmoved, seed}.p_WS_mm(point.q);
      point.p_WS_mm = noisy_reading(arm.p_WS_mm(point.q) + change_mm, noise, random);
      point.direction = arm.directions();
      data.points.push_back(point);
    }
    const std::optional<MeasurementNoise> stated =
        of.noise_stated ? std::optional(kCampaignNoise) : std::nullopt;
    const auto made = calibrate(example::kr210(), data, {.noise = stated, .check_model = false});
    EXPECT_TRUE(made);
    if (!made) continue;
    std::vector<std::size_t> far;
    for (const auto* points : {&made->rejected, &made->validation_outliers})
      for (const RejectedPoint& point : *points) far.push_back(point.point);
    const auto found = movement(made->cell, as_fitted(*made, data).points, stated, far);
    if (!found) continue;
    ++rates.reported;
    const bool named = of.change && found->what == *of.change;
    rates.named += named;
    rates.listed +=
        named || (of.change && std::ranges::count(found->or_else, *of.change, &ChangeHypothesis::what) > 0);
    rates.at_moment +=
        of.little_by_little ? found->first == 0 : found->first == moment && found->again == again;
  }
  std::cout << row << ": of " << rates.runs << " reported " << rates.reported << ", named " << rates.named
            << ", or listed " << rates.listed << ", with its moment " << rates.at_moment << "\n";
  return rates;
}

TEST(MovementOverManyCampaigns, IsSeldomReportedWhereNothingChanged) {
  const auto seldom = [](const Rates& rates) { EXPECT_LE(rates.reported, all_trials() ? 2 : 1); };
  seldom(rates("unchanged, 60 poses", {}));
  seldom(rates("unchanged, 24 poses", {.poses = 24}));
  seldom(rates("unchanged, 16 poses", {.poses = 16}));
  seldom(rates("unchanged, no noise stated", {.noise_stated = false}));
  seldom(rates("unchanged, a fifth noisier than stated", {.noisier = 1.2}));
  seldom(rates("unchanged, thrice as noisy as stated", {.noisier = 3}));
  seldom(rates("unchanged, gears", {.errors = heavy_arm_errors({.compliance = false})}));
  seldom(rates("unchanged, bends", {.errors = heavy_arm_errors({})}));
}

TEST(MovementOverManyCampaigns, OfTheTrackerIsNamedWithItsMoment) {
  for (const double moved_mm : {0.03, 0.05, 0.1, 0.3}) {
    const auto make = [=](TrueArmSetup& truth, double share) {
      truth.X_WB.translation() += share * moved_mm * Eigen::Vector3d(0.6, 0, 0.8);
    };
    std::cout << moved_mm << " mm: ";
    const Rates step = rates("base", {.change = Change{ChangeKind::Base}, .make = make});
    std::cout << moved_mm << " mm: ";
    const Rates few =
        rates("base, 24 poses", {.poses = 24, .change = Change{ChangeKind::Base}, .make = make});
    std::cout << moved_mm << " mm: ";
    rates("base, no noise stated", {.noise_stated = false, .change = Change{ChangeKind::Base}, .make = make});
    std::cout << moved_mm << " mm: ";
    rates("base, gears", {.errors = heavy_arm_errors({.compliance = false}),
                          .change = Change{ChangeKind::Base},
                          .make = make});
    std::cout << moved_mm << " mm: ";
    const Rates trend = rates("base little by little",
                              {.change = Change{ChangeKind::Base}, .make = make, .little_by_little = true});
    std::cout << moved_mm << " mm: ";
    rates("base and back", {.change = Change{ChangeKind::Base}, .make = make, .back = true});
    if (moved_mm < 0.1) continue;
    EXPECT_GE(step.named, least_rate(0.97) * step.runs);
    if (moved_mm < 0.3) continue;
    for (const Rates& rates : {few, trend}) EXPECT_GE(rates.named, least_rate(0.97) * rates.runs);
  }
}

TEST(MovementOverManyCampaigns, OfAJointsZeroIsNamed) {
  for (const double moved_deg : {0.005, 0.01, 0.02}) {
    for (int joint = 1; joint < 5; ++joint) {
      const auto make = [=](TrueArmSetup& truth, double share) {
        truth.robot.joints[static_cast<std::size_t>(joint)].theta_rad += share * moved_deg * kRadPerDeg;
      };
      std::cout << moved_deg << " deg: axis " << joint + 1 << " ";
      const Rates found = rates("zero", {.change = Change{ChangeKind::JointZero, joint}, .make = make});
      if (moved_deg < 0.02 || joint >= 3) continue;
      EXPECT_GE(found.listed, least_rate(0.95) * found.runs);
    }
  }
}

TEST(MovementOverManyCampaigns, OfAReflectorOrAllZerosOrTheLengthsIsNamed) {
  for (const double times : {0.5, 1.0, 2.0}) {
    const auto reflector = [=](TrueArmSetup& truth, double share) {
      truth.p_FS_mm += share * times * Eigen::Vector3d(0.06, 0, 0.08);
    };
    const auto zeros = [=](TrueArmSetup& truth, double share) {
      constexpr std::array kWays_deg{0.006, -0.008, 0.01, -0.02, 0.015, 0.02};
      for (std::size_t i = 0; i < kWays_deg.size(); ++i)
        truth.robot.joints[i].theta_rad += share * times * kWays_deg[i] * kRadPerDeg;
    };
    const auto lengths = [=](TrueArmSetup& truth, double share) {
      for (Joint& joint : truth.robot.joints) {
        joint.a_mm *= 1 + share * times * 50e-6;
        joint.d_mm *= 1 + share * times * 50e-6;
      }
    };
    std::cout << times << " times: ";
    const Rates one = rates("reflector", {.change = Change{ChangeKind::Reflector}, .make = reflector});
    std::cout << times << " times: ";
    rates("reflector little by little",
          {.change = Change{ChangeKind::Reflector}, .make = reflector, .little_by_little = true});
    std::cout << times << " times: ";
    rates("all zeros", {.change = Change{ChangeKind::AllZeros}, .make = zeros});
    std::cout << times << " times: ";
    rates("lengths", {.change = Change{ChangeKind::Growth}, .make = lengths});
    EXPECT_GE(one.named, least_rate(0.97) * one.runs);
  }
}

}  // namespace
}  // namespace truepose
