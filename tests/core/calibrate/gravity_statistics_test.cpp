// What gravity and rails do to arms, and what is left of it.

#include <gtest/gtest.h>

#include <iostream>

#include "core/calibrate/calibrate.hpp"
#include "tests/core/example_arms.hpp"
#include "tests/core/example_campaigns.hpp"
#include "tests/trials.hpp"

namespace truepose {
namespace {

/// What the public model of the KR 210 R2700-2 (kroshu/kuka_robot_descriptions, kuka_quantec_support) says of
/// its links, in the frames of its robot file.
const std::vector<LinkMass> kPublicMasses{{363.07, {28.8, -11.9, -411.0}}, {232.06, {486.9, -1.9, -117.6}},
                                          {190.33, {173.8, -76.0, 136.2}}, {42.41, {0, -19.2, -1022.1}},
                                          {16.99, {62.2, 0.3, -65.8}},     {6.60, {0, 0, -208.5}}};

/// Springs, gears and the public masses, with what the flange carries (the flange is the last link's frame).
NonGeometricErrors loaded(const LinkMass& payload, std::uint64_t seed) {
  NonGeometricErrors errors = heavy_arm_errors({.seed = seed});
  errors.masses = kPublicMasses;
  LinkMass& last = errors.masses.back();
  const double kg = last.mass_kg + payload.mass_kg;
  last = {kg, (last.mass_kg * last.centre_mm + payload.mass_kg * payload.centre_mm) / kg};
  return errors;
}

constexpr double kKg = 150;
const Eigen::Vector3d kCentre_mm{0, 0, 200};

TEST(Gravity, OfAnArmWithPublicMassesAndAHeavyToolIsRemoved) {
  double with = 0, known = 0, without = 0;
  const int count = trials(100);
  for (int seed = 1; seed <= count; ++seed) {
    const auto n = static_cast<std::uint64_t>(seed);
    const SimulatedCampaign c =
        example::campaign(example::true_arm(loaded({kKg, kCentre_mm}, n)), 80, 60, {.seed = n});
    RobotModel weighed = example::kr210();
    weighed.masses = kPublicMasses;
    weighed.payload = LinkMass{kKg, kCentre_mm};
    without += example::mean_miss(calibrate(example::kr210(), c.data), c);
    with += example::mean_miss(calibrate(example::kr210(), c.data, {.non_geometric = true}), c);
    known += example::mean_miss(calibrate(weighed, c.data, {.non_geometric = true}), c);
  }
  std::cout << count << " arms: without " << without / count << ", masses unknown " << with / count
            << ", known " << known / count << " mm\n";
  EXPECT_LT(with / count, 0.045);
  EXPECT_LT(known / count, 0.045);
}

/// Adds points that were measured with another payload; each row states its payload.
void add(SimulatedCampaign& to, SimulatedCampaign more, const LinkMass& payload) {
  for (Measurement& point : more.data.points) point.payload = payload;
  to.data.smr_names = more.data.smr_names;
  std::ranges::move(more.data.points, std::back_inserter(to.data.points));
  std::ranges::move(more.p_true_mm, std::back_inserter(to.p_true_mm));
}

double miss_with(const CalibratedCell& cell, const SimulatedCampaign& fresh, const LinkMass& payload) {
  CalibratedCell loaded = cell;
  loaded.robot.payload = payload;
  return example::mean_miss(loaded, fresh);
}

TEST(Gravity, FollowsAPayloadThatWasNotMeasured) {
  // Measured empty and with 150 kg, used with 80 kg elsewhere on the flange, the masses unknown.
  const LinkMass none{0, {0, 0, 0}}, heavy{kKg, kCentre_mm}, other{80, {60, 0, 120}};
  double given = 0, not_given = 0;
  const int count = trials(100);
  for (int seed = 1; seed <= count; ++seed) {
    const auto n = static_cast<std::uint64_t>(seed);
    SimulatedCampaign c;
    add(c, example::campaign(example::true_arm(loaded(none, n)), 40, 0, {.seed = n}), none);
    add(c, example::campaign(example::true_arm(loaded(heavy, n)), 40, 0, {.seed = n + 500}), heavy);
    const SimulatedCampaign fresh =
        example::campaign(example::true_arm(loaded(other, n)), 1, 60, {.seed = n + 900});
    const auto with = calibrate(example::kr210(), c.data, {.non_geometric = true});
    ASSERT_TRUE(with) << with.error().detail;
    given += miss_with(with->cell, fresh, other);
    for (Measurement& point : c.data.points) point.payload = std::nullopt;
    not_given += example::mean_miss(calibrate(example::kr210(), c.data, {.non_geometric = true}), fresh);
  }
  std::cout << count << " arms: payload given " << given / count << ", not given " << not_given / count
            << " mm\n";
  EXPECT_LT(given / count, 0.060);
  EXPECT_LT(given, 0.5 * not_given);
}

TEST(Rails, WhosePitchIsOffAreIdentified) {
  for (const double ppm : {300.0, 1000.0}) {
    double sum = 0;
    const int count = trials(100);
    for (int seed = 1; seed <= count; ++seed) {
      Random random{static_cast<std::uint64_t>(seed)};
      const RobotModel nominal = example::kr210_on_a_rail();
      CalibratedCell truth = example::placed(example::deviating(nominal, random, 0.5, 1e-3), random);
      truth.robot.deviation = {{0, DeviationBasis::Scale, 1, 1e-3 * ppm}};  // mm/m
      MeasurementData data = example::measured(truth, 60, example::kSigma_mm, random);
      MeasurementData fresh = example::measured(truth, 60, 0, random);
      for (Measurement& point : fresh.points) {
        point.set = PoseSet::Validate;
        data.points.push_back(point);
      }
      const auto result = calibrate(nominal, data, {.non_geometric = true});
      ASSERT_TRUE(result) << result.error().detail;
      sum += result->validate->after.mean;
    }
    std::cout << ppm << " ppm: " << sum / count << " mm over " << count << " arms\n";
    EXPECT_LT(sum / count, 0.03);
  }
}

}  // namespace
}  // namespace truepose
