#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/arm/forward.hpp"
#include "core/calibrate/calibrate.hpp"
#include "core/data/calibrated_cell.hpp"
#include "core/fit/measurement_model.hpp"
#include "core/quality/calibration_verdict.hpp"
#include "tests/core/example_arms.hpp"
#include "tests/core/least_variance.hpp"

namespace truepose {
namespace {

using testing::HasSubstr;

BasePose elsewhere(Random& random) { return example::placed(example::kr210(), random).base; }

Eigen::Vector3d noise(Random& random, double sigma_mm) {
  const double x = random.normal(), y = random.normal(), z = random.normal();
  return sigma_mm * Eigen::Vector3d(x, y, z);
}

/// What a tracker reads from one station of the reflectors of a cell, named as `names` says.
MeasurementData seen(const CalibratedCell& truth, const BasePose& base, int poses, double sigma_mm,
                     Random& random, const std::string& station, std::vector<std::string> names = {"1"}) {
  MeasurementData data{.smr_names = std::move(names), .points = {}, .stations = {station}};
  for (int k = 0; k < poses; ++k) {
    const JointVector q = example::random_joints(truth.robot, random);
    for (std::size_t smr = 0; smr < data.smr_names.size(); ++smr) {
      const Eigen::Vector3d p_B = forward_kinematics(truth.robot, q) * truth.reflectors[smr].p_FS_mm;
      data.points.push_back({.q = q,
                             .p_WS_mm = base.isometry() * p_B + noise(random, sigma_mm),
                             .smr = static_cast<int>(smr),
                             .row = static_cast<int>(data.points.size()) + 1});
    }
  }
  return data;
}

MeasurementData validating(MeasurementData data) {
  for (Measurement& point : data.points) point.set = PoseSet::Validate;
  return data;
}

/// Puts the points of the same station, by its name, behind those that are there.
void append(MeasurementData& data, const MeasurementData& more, int station) {
  for (Measurement point : more.points) {
    point.station = station;
    data.points.push_back(point);
  }
}

TEST(Stations, TheBaseOfEachIsFoundWithOneArmAndReflector) {
  Random random{51};
  CalibratedCell truth = example::placed(example::with_paper_errors(example::kr210()), random);
  truth.further_bases = {elsewhere(random), elsewhere(random)};
  MeasurementData data = seen(truth, truth.base, 12, 0, random, "monday");
  add_station(data, seen(truth, truth.base_at(1), 25, 0, random, "door"));
  add_station(data, seen(truth, truth.base_at(2), 10, 0, random, "window"));
  for (int s = 0; s < 3; ++s) append(data, validating(seen(truth, truth.base_at(s), 5, 0, random, "")), s);
  const auto found = calibrate(example::kr210(), data);
  ASSERT_TRUE(found) << found.error().detail;
  EXPECT_EQ(found->rank, 27 + 2 * 6);
  EXPECT_LT(found->validate->after.max, 1e-6);
  ASSERT_EQ(found->stations.size(), 3U);
  EXPECT_EQ(found->stations[1].identify.poses, 25);
  EXPECT_EQ(found->stations[2].validate->poses, 5);
  EXPECT_LT(found->stations[2].validate->after.max, 1e-6);
  // The base of the arm is a convention, from station to station it is the tracker's way.
  for (int s = 1; s < 3; ++s) {
    const Eigen::Isometry3d way = found->cell.station_pose(s), true_way = truth.station_pose(s);
    EXPECT_LT((way.translation() - true_way.translation()).norm(), 1e-5);
    EXPECT_LT((way.linear() - true_way.linear()).norm(), 1e-8);
  }
}

TEST(Stations, TogetherTheyReachTheStatisticalLimit) {
  constexpr int kTrials = 25;
  Random random{52};
  double squared = 0, bound = 0;
  for (int trial = 0; trial < kTrials; ++trial) {
    CalibratedCell truth = example::placed(example::deviating(example::kr210(), random, 0.5, 1e-3), random);
    truth.further_bases = {elsewhere(random)};
    MeasurementData data = seen(truth, truth.base, 25, example::kSigma_mm, random, "a");
    add_station(data, seen(truth, truth.base_at(1), 15, example::kSigma_mm, random, "b"));
    MeasurementData fresh = seen(truth, truth.base, 20, 0, random, "a");
    add_station(fresh, seen(truth, truth.base_at(1), 20, 0, random, "b"));

    bound += least_variance(truth, data, fresh);
    const auto found = calibrate(example::kr210(), data);
    ASSERT_TRUE(found) << found.error().detail;
    squared += residuals(found->cell, fresh.points).squaredNorm();
  }
  EXPECT_NEAR(std::sqrt(squared / bound), 1, 0.06);
}

TEST(Stations, ThreePosesPlaceATrackerThatSeesAKnownReflector) {
  Random random{53};
  CalibratedCell truth = example::placed(example::with_paper_errors(example::kr210()), random);
  truth.further_bases = {elsewhere(random)};
  MeasurementData data = seen(truth, truth.base_at(1), 3, 0, random, "few");
  add_station(data, seen(truth, truth.base, 40, 0, random, "many"));
  const auto found = calibrate(example::kr210(), data);
  ASSERT_TRUE(found) << found.error().detail;
  EXPECT_LT(found->identify.after.max, 1e-6);
}

TEST(Stations, AReflectorThatWasMountedAgainHasAnotherName) {
  Random random{54};
  CalibratedCell truth = example::placed(example::with_paper_errors(example::kr210()), random, 3);
  truth.further_bases = {elsewhere(random)};
  MeasurementData data = seen(truth, truth.base, 30, 0, random, "a", {"1", "2"});
  CalibratedCell moved = truth;
  moved.reflectors = {truth.reflectors[2], truth.reflectors[1]};
  add_station(data, seen(moved, truth.base_at(1), 20, 0, random, "b", {"1 moved", "2"}));
  EXPECT_EQ(data.smr_names, (std::vector<std::string>{"1", "2", "1 moved"}));
  const auto found = calibrate(example::kr210(), data);
  ASSERT_TRUE(found) << found.error().detail;
  EXPECT_LT(found->identify.after.max, 1e-6);
  const auto distance = [](const CalibratedCell& cell, std::size_t i, std::size_t j) {
    return (cell.reflectors[i].p_FS_mm - cell.reflectors[j].p_FS_mm).norm();
  };
  EXPECT_NEAR(distance(found->cell, 1, 2), distance(truth, 1, 2), 1e-6);
}

TEST(Stations, OutliersAreRejectedFromEach) {
  Random random{55};
  CalibratedCell truth = example::placed(example::with_paper_errors(example::kr210()), random);
  truth.further_bases = {elsewhere(random)};
  MeasurementData data = seen(truth, truth.base, 40, example::kSigma_mm, random, "a");
  add_station(data, seen(truth, truth.base_at(1), 40, example::kSigma_mm, random, "b"));
  for (const std::size_t bad : {3U, 20U, 45U, 60U, 61U}) data.points[bad].p_WS_mm.x() += 20;
  const auto found = calibrate(example::kr210(), data, {.loss = Loss::Tukey});
  ASSERT_TRUE(found) << found.error().detail;
  ASSERT_EQ(found->rejected.size(), 5U);
  EXPECT_EQ(found->rejected[2].point, 45U);
  EXPECT_NEAR(found->rejected[2].residual_mm, 20, 0.2);
}

TEST(Stations, WithPriorDeviationsAndFieldEachIsRegarded) {
  Random random{56};
  RobotModel real = example::deviating(example::kr210(), random, 0.3, 3e-4);
  real.deviation = {{.joint = 1, .basis = DeviationBasis::Sine, .order = 1, .coefficient = 2e-4},
                    {.joint = 2, .basis = DeviationBasis::Cosine, .order = 2, .coefficient = 1e-4}};
  CalibratedCell truth = example::placed(real, random);
  truth.further_bases = {elsewhere(random)};
  MeasurementData data = seen(truth, truth.base, 60, example::kSigma_mm, random, "a");
  add_station(data, seen(truth, truth.base_at(1), 60, example::kSigma_mm, random, "b"));
  for (int s = 0; s < 2; ++s) append(data, validating(seen(truth, truth.base_at(s), 30, 0, random, "")), s);
  const auto found = calibrate(example::kr210(), data,
                               {.prior = PriorUse::On, .non_geometric = true, .field = FieldUse::Always});
  ASSERT_TRUE(found) << found.error().detail;
  for (const StationErrors& station : found->stations) EXPECT_LT(station.validate->after.mean, 0.035);
}

TEST(Stations, OneWithoutPointsOrWithTooFewIsNamed) {
  Random random{57};
  const CalibratedCell truth = example::placed(example::kr210(), random);
  MeasurementData data = seen(truth, truth.base, 30, 0, random, "a.csv");
  MeasurementData empty = data, few = data;
  add_station(empty, validating(seen(truth, truth.base, 5, 0, random, "b.csv")));
  EXPECT_EQ(calibrate(example::kr210(), empty).error().detail,
            "station 'b.csv' has no point to identify its base from");
  add_station(few, seen(truth, truth.base, 2, 0, random, "b.csv"));
  EXPECT_EQ(calibrate(example::kr210(), few).error().detail,
            "station 'b.csv': at least 3 points are needed to see a rotation: measure five poses from it, or "
            "three that show reflectors that another station has seen");
}

TEST(Stations, AMistakeInOneSetIsReportedForIt) {
  Random random{58};
  const CalibratedCell truth = example::placed(example::with_paper_errors(example::kr210()), random);
  MeasurementData data = seen(truth, truth.base, 30, 0, random, "a.csv");
  MeasurementData wrong = seen(truth, elsewhere(random), 30, 0, random, "b.csv");
  for (Measurement& point : wrong.points) point.p_WS_mm /= 25.4;
  add_station(data, wrong);
  const auto refused = calibrate(example::kr210(), data);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().fault, CalibrationFault::WrongModel);
  EXPECT_TRUE(refused.error().detail.starts_with("station 'b.csv': ")) << refused.error().detail;
}

TEST(Stations, AJointThatSlippedDidSoAtARowOfOne) {
  Random random{57};
  CalibratedCell truth = example::placed(example::with_paper_errors(example::kr210()), random);
  truth.further_bases = {elsewhere(random)};
  MeasurementData data = seen(truth, truth.base, 40, example::kSigma_mm, random, "a");
  CalibratedCell slipped = truth;
  slipped.robot.joints[2].theta_rad += 2e-3;
  MeasurementData later = seen(truth, truth.base_at(1), 15, example::kSigma_mm, random, "b");
  append(later, seen(slipped, truth.base_at(1), 40, example::kSigma_mm, random, "b"), 0);
  for (std::size_t i = 0; i < later.points.size(); ++i) later.points[i].row = static_cast<int>(i) + 1;
  add_station(data, std::move(later));
  const MeasurementNoise noise{.repeatability_mm = example::kSigma_mm};
  const auto found = calibrate(example::kr210(), data, {.noise = noise});
  ASSERT_TRUE(found) << found.error().detail;
  const CalibrationVerdict verdict =
      calibration_verdict({.calibration = *found, .data = data, .stated = noise});
  ASSERT_FALSE(verdict.findings.empty());
  EXPECT_THAT(verdict.findings.front().sentence, HasSubstr("the encoder offset of joint 3 changed"));
  EXPECT_THAT(verdict.findings.front().sentence,
              HasSubstr("between the points 55 and 56 (row 16 of 'b') that were measured"));
}

}  // namespace
}  // namespace truepose
