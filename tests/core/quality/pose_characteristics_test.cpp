#include "core/quality/pose_characteristics.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "core/math/angles.hpp"
#include "core/math/random.hpp"
#include "core/quality/iso9283.hpp"
#include "tests/core/iso9283_example.hpp"

namespace truepose {
namespace {

Eigen::Matrix3d rotation(double a_deg, double b_deg, double c_deg) {
  return pose_from_kuka({0, 0, 0}, {a_deg, b_deg, c_deg}).linear();
}

std::vector<TestPose> random_cloud(Random& random, int count) {
  std::vector<TestPose> cloud;
  const auto normal = [&] { return random.normal(); };
  for (int i = 0; i < count; ++i) {
    const Eigen::Vector3d turn = 1e-3 * Eigen::Vector3d::NullaryExpr(normal);
    cloud.push_back({.p_mm = Eigen::Vector3d(1500, 20, 900) + 0.1 * Eigen::Vector3d::NullaryExpr(normal),
                     .R = Eigen::AngleAxisd(turn.norm(), turn.normalized()) * rotation(10, 90, 0)});
  }
  return cloud;
}

// Commanded (1000, 0, 800). Five cycles, in um from there less (12, -16, 21): (3, 4, 0), (-3, -4, 0),
// (6, 8, 0), (-6, -8, 0), (0, 0, 0). They sum to zero, so that
//   AP_x, AP_y, AP_z = 12, -16, 21 um    AP_p = sqrt(144 + 256 + 441) = 29 um
//   l = 5, 5, 10, 10, 0 um               mean l = 6 um
//   S_l = sqrt((1 + 1 + 16 + 16 + 36) / 4) = sqrt(17.5) = 4.183300132670377797976 um
//   RP_l = 6 + 3 S_l = 18.549900398011133393929 um
TEST(PoseCharacteristics, GiveTheFiguresOfATableWorkedByHand) {
  const TestPose commanded{.p_mm = {1000, 0, 800}};
  std::vector<TestPose> attained;
  for (const auto& [x, y] : {std::pair{3, 4}, {-3, -4}, {6, 8}, {-6, -8}, {0, 0}})
    attained.push_back({.p_mm = commanded.p_mm + Eigen::Vector3d(12 + x, -16 + y, 21) / 1000});

  const PoseAccuracy ap = pose_accuracy(commanded, attained);
  EXPECT_NEAR(ap.p_mm, 0.029, 1e-12);
  EXPECT_LT((ap.xyz_mm - Eigen::Vector3d(0.012, -0.016, 0.021)).norm(), 1e-12);
  EXPECT_FALSE(ap.abc_rad);
  const auto rp = pose_repeatability(attained);
  ASSERT_TRUE(rp);
  EXPECT_NEAR(rp->mean_mm, 0.006, 1e-12);
  EXPECT_NEAR(rp->std_mm, 0.004183300132670377797976, 1e-12);
  EXPECT_NEAR(rp->l_mm, 0.018549900398011133393929, 1e-12);
  EXPECT_FALSE(rp->abc_rad);
}

TEST(PoseCharacteristics, GiveTheFiguresOfThirtyCyclesAtFivePointsWorkedToFiftyDigits) {
  for (int k = 1; k <= 5; ++k) {
    std::vector<TestPose> attained;
    for (int j = 1; j <= 30; ++j)
      attained.push_back({.p_mm = example::commanded_mm(k) + example::deviation_mm(k, j)});
    const example::WorkedFigures& worked = example::kWorkedFigures[static_cast<std::size_t>(k - 1)];
    const PoseAccuracy ap = pose_accuracy({.p_mm = example::commanded_mm(k)}, attained);
    const auto rp = pose_repeatability(attained);
    ASSERT_TRUE(rp);
    const Eigen::Vector3d xyz(worked.ap_x, worked.ap_y, worked.ap_z);
    EXPECT_LT((ap.xyz_mm - xyz).cwiseAbs().maxCoeff(), 1e-12) << k;
    EXPECT_NEAR(ap.p_mm, worked.ap_p, 1e-12) << k;
    EXPECT_NEAR(rp->mean_mm, worked.l_mean, 1e-12) << k;
    EXPECT_NEAR(rp->std_mm, worked.l_std, 1e-12) << k;
    EXPECT_NEAR(rp->l_mm, worked.rp_l, 1e-12) << k;
  }
}

// Turns of 10, 20, 30, 40, 50 mdeg about the base's z: AP_c = 30 mdeg, S_c = sqrt((400 + 100 + 0 + 100 + 400)
// / 4) = sqrt(250) mdeg, RP_c = 3 S_c = 47.434164902525689... mdeg. In KUKA's gimbal, at +-180 deg and upside
// down these angles cannot be subtracted from the printed A, B, C.
TEST(PoseCharacteristics, TakeTurnsAboutTheBasesAxesWhateverTheAnglesAre) {
  for (const Eigen::Matrix3d& R :
       {rotation(0, 90, 0), rotation(179.99, 0, -180), rotation(30, -90, 20), rotation(0, 0, 0)}) {
    std::vector<TestPose> attained;
    for (const double mdeg : {10, 20, 30, 40, 50})
      attained.push_back({.R = Eigen::AngleAxisd(mdeg * 1e-3 * kRadPerDeg, Eigen::Vector3d::UnitZ()) * R});
    const PoseAccuracy ap = pose_accuracy({.R = R}, attained);
    ASSERT_TRUE(ap.abc_rad);
    EXPECT_LT((*ap.abc_rad * kDegPerRad - Eigen::Vector3d(0, 0, 0.030)).norm(), 1e-12);
    const auto rp = pose_repeatability(attained);
    ASSERT_TRUE(rp && rp->abc_rad);
    EXPECT_LT((*rp->abc_rad * kDegPerRad - Eigen::Vector3d(0, 0, 0.047434164902525689)).norm(), 1e-12);
  }
}

TEST(PoseCharacteristics, RepeatabilityDoesNotFeelWhereTheCloudIsNorInWhichOrderItCame) {
  Random random{20261121};
  std::vector<TestPose> cloud = random_cloud(random, 30);
  const auto before = pose_repeatability(cloud);
  for (TestPose& pose : cloud) pose.p_mm += Eigen::Vector3d(700, -30, 5);
  std::ranges::reverse(cloud);
  std::ranges::rotate(cloud, cloud.begin() + 7);
  const auto after = pose_repeatability(cloud);
  ASSERT_TRUE(before && after);
  EXPECT_NEAR(before->l_mm, after->l_mm, 1e-11);
  EXPECT_LT((*before->abc_rad - *after->abc_rad).norm(), 1e-12);
}

TEST(PoseCharacteristics, AccuracyMovesWithTheCloudAndTurnsWithTheFrame) {
  Random random{20261122};
  std::vector<TestPose> cloud = random_cloud(random, 30);
  TestPose commanded{.p_mm = {1500, 20, 900}, .R = rotation(10, 90, 0)};
  const PoseAccuracy before = pose_accuracy(commanded, cloud);
  const Eigen::Vector3d shift(0.3, -0.2, 0.1);
  for (TestPose& pose : cloud) pose.p_mm += shift;
  EXPECT_LT((pose_accuracy(commanded, cloud).xyz_mm - before.xyz_mm - shift).norm(), 1e-11);

  const Eigen::Matrix3d frame = rotation(120, 35, -70);
  for (TestPose& pose : cloud) pose = {.p_mm = frame * (pose.p_mm - shift), .R = frame * *pose.R};
  commanded = {.p_mm = frame * commanded.p_mm, .R = frame * *commanded.R};
  const PoseAccuracy turned = pose_accuracy(commanded, cloud);
  EXPECT_NEAR(turned.p_mm, before.p_mm, 1e-11);
  EXPECT_LT((turned.xyz_mm - frame * before.xyz_mm).norm(), 1e-11);
  EXPECT_LT((*turned.abc_rad - frame * *before.abc_rad).norm(), 1e-12);
}

TEST(PoseCharacteristics, OneCycleHasNoRepeatability) {
  const std::vector<TestPose> one(1);
  const auto rp = pose_repeatability(one);
  ASSERT_FALSE(rp);
  EXPECT_EQ(rp.error(), "one cycle has no repeatability, at least 2 are needed");
}

TEST(PoseCharacteristics, LeaveOrientationOutWhereOnePoseHasNone) {
  Random random{3};
  std::vector<TestPose> cloud = random_cloud(random, 3);
  cloud[1].R.reset();
  EXPECT_FALSE(pose_accuracy({.R = rotation(10, 90, 0)}, cloud).abc_rad);
  EXPECT_FALSE(pose_repeatability(cloud)->abc_rad);
}

// Means at (0, 0, 0), (3, 4, 0), (3, 4, 12) um: the farthest two are sqrt(9 + 16 + 144) = 13 um apart.
TEST(PoseCharacteristics, VariationIsTheWayBetweenTheFarthestDirections) {
  const std::vector<TestPose> means{{.R = rotation(0, 90, 0)},
                                    {.p_mm = {0.003, 0.004, 0}, .R = rotation(0.01, 90, 0)},
                                    {.p_mm = {0.003, 0.004, 0.012}, .R = rotation(-0.02, 90, 0)}};
  const AccuracyVariation variation = accuracy_variation(means);
  EXPECT_NEAR(variation.p_mm, 0.013, 1e-15);
  ASSERT_TRUE(variation.abc_rad);
  EXPECT_LT((*variation.abc_rad * kDegPerRad - Eigen::Vector3d(0, 0, 0.03)).norm(), 1e-12);
}

TEST(PoseCharacteristics, DriftIsTheGreatestChangeFromTheFirstSeries) {
  const auto series = [](double x, double y, double rp) {
    return SeriesCharacteristics{{.p_mm = std::hypot(x, y), .xyz_mm = {x, y, 0}}, {.l_mm = rp}};
  };
  // Half around the commanded position: dAP_p shows the third series alone, the way shows both.
  const std::vector<SeriesCharacteristics> all{series(0.05, 0, 0.020), series(-0.05, 0, 0.026),
                                               series(0.02, 0, 0.016)};
  const PoseDrift drift = pose_drift(all);
  EXPECT_NEAR(drift.ap_p_mm, 0.03, 1e-15);
  EXPECT_NEAR(drift.rp_l_mm, 0.006, 1e-15);
  EXPECT_NEAR(drift.moved_mm, 0.10, 1e-15);
  EXPECT_FALSE(drift.ap_abc_rad);
  EXPECT_FALSE(drift.rp_abc_rad);
}

TestPoint wandering_point() {
  TestPoint point{.name = "P1", .commanded = {.p_mm = {1000, 0, 0}}};
  for (const char* time : {"0 min", "60 min"}) {
    const double shift = time[0] == '0' ? 0 : 0.04;
    for (const char* direction : {"+x", "+y", "+z"}) {
      const double aside = direction[1] == 'z' ? 0.01 : 0;
      for (const double wobble : {-0.002, 0.002}) {
        point.attained.push_back({{.p_mm = {1000.1 + shift + wobble, aside, 0}}, direction, time});
      }
    }
  }
  return point;
}

TEST(Iso9283Evaluation, JudgesEachDirectionAndSeriesByItself) {
  const std::vector<TestPoint> points{wandering_point()};
  const auto result = evaluate_iso9283(points);
  ASSERT_TRUE(result) << result.error();
  ASSERT_EQ(result->sets.size(), 6U);
  EXPECT_EQ(result->fewest_cycles, 2);
  for (const CycleSet& set : result->sets) EXPECT_NEAR(set.characteristics.repeatability.l_mm, 0.002, 1e-9);
  ASSERT_EQ(result->variations.size(), 2U);
  EXPECT_EQ(result->variations[1].series, "60 min");
  EXPECT_EQ(result->variations[1].directions.size(), 3U);
  EXPECT_NEAR(result->variations[1].variation.p_mm, 0.01, 1e-9);
  ASSERT_EQ(result->drifts.size(), 3U);
  EXPECT_EQ(result->drifts[0].direction, "+x");
  EXPECT_NEAR(result->drifts[0].drift.ap_p_mm, 0.04, 1e-9);
}

TEST(Iso9283Evaluation, LeavesTheCyclesFromPoseToPoseOutOfTheVariation) {
  std::vector<TestPoint> points{wandering_point()};
  for (const double wobble : {-0.002, 0.002})
    points[0].attained.push_back({{.p_mm = {1000.5 + wobble, 0, 0}}, {}, "0 min"});
  const auto result = evaluate_iso9283(points);
  ASSERT_TRUE(result) << result.error();
  EXPECT_EQ(result->sets.size(), 7U);
  ASSERT_EQ(result->variations.size(), 2U);
  EXPECT_EQ(result->variations[0].directions.size(), 3U);
  EXPECT_NEAR(result->variations[0].variation.p_mm, 0.01, 1e-9);
}

TEST(Iso9283Evaluation, NamesTheSetOfASingleCycle) {
  std::vector<TestPoint> points{wandering_point()};
  points[0].attained.pop_back();
  const auto result = evaluate_iso9283(points);
  ASSERT_FALSE(result);
  EXPECT_EQ(result.error(),
            "P1, direction +z, series 60 min: one cycle has no repeatability, at least 2 are needed");
}

TEST(Iso9283Evaluation, AFittedFrameTakesUpWhatIsCommonToAllPoints) {
  std::vector<TestPoint> points;
  for (int k = 1; k <= 5; ++k) {
    TestPoint point{.name = "P", .commanded = {.p_mm = example::commanded_mm(k)}};
    for (int j = 1; j <= 30; ++j)
      point.attained.push_back({{.p_mm = point.commanded.p_mm + example::deviation_mm(1, j)}, "", ""});
    points.push_back(point);
  }
  Eigen::Isometry3d X_MB = Eigen::Isometry3d::Identity();
  X_MB.linear() = rotation(100, 20, -50);
  X_MB.translation() = Eigen::Vector3d(4000, -300, 1200);
  const std::vector<TestPoint> measured = in_base(points, X_MB);  // as a tracker sees it
  const auto X_BM = fitted_frame(measured);
  ASSERT_TRUE(X_BM) << X_BM.error();
  const auto absolute = evaluate_iso9283(points);
  const auto relative = evaluate_iso9283(in_base(measured, *X_BM));
  ASSERT_TRUE(absolute && relative);
  for (std::size_t k = 0; k < 5; ++k) {
    const SeriesCharacteristics& a = absolute->sets[k].characteristics;
    const SeriesCharacteristics& r = relative->sets[k].characteristics;
    EXPECT_NEAR(a.repeatability.l_mm, r.repeatability.l_mm, 1e-9);
    EXPECT_NEAR(a.accuracy.p_mm, example::kWorkedFigures[0].ap_p, 1e-9);
    EXPECT_LT(r.accuracy.p_mm, 1e-9);
  }

  points.resize(2);
  EXPECT_FALSE(fitted_frame(points));
}

}  // namespace
}  // namespace truepose
