// Campaigns with several reflectors on one flange.
#include <gmock/gmock.h>

#include <cmath>
#include <cstdio>
#include <map>
#include <set>

#include "core/arm/forward.hpp"
#include "core/math/angles.hpp"
#include "daemon/campaign/corrected_points.hpp"
#include "tests/daemon/campaign_fixture.hpp"

namespace truepose::daemon {
namespace {

struct ReflectorsCampaignTest : CampaignTest {
  ReflectorsCampaignTest() {
    config.reflector.name = "a";
    config.tracker.noise = {.range_mm = 0.01, .transverse_mm = 0.01};
    // b looks where a does, c to the side.
    config.further_reflectors = {{.name = "b", .p_FS_mm = {-90, 30, 50}},
                                 {.name = "c", .p_FS_mm = {20, -110, 70}, .facing_F = {0.6, 0, 0.8}}};
    for (const config::ReflectorConfig& reflector : config.further_reflectors)
      truth.truth.further.push_back(
          {reflector.p_FS_mm + Eigen::Vector3d{-3, 2, 4}, reflector.facing_F, truth.truth.acceptance_rad});
  }
  const CampaignResult& run() {
    start();
    EXPECT_TRUE(go_on());
    if (!*outcome) throw std::runtime_error{outcome->error().detail};
    return ***outcome;
  }
  void expect_every_point_where_its_reflector_was() {
    config.campaign.remeasure = false;
    const CampaignResult& result = run();
    for (const StoredPoint& point : result.points) {
      if (!shows_arm(point)) continue;
      Eigen::Vector3d p_F_mm = truth.truth.p_FS_mm;
      for (std::size_t k = 0; k < config.further_reflectors.size(); ++k)
        if (config.further_reflectors[k].name == point.smr) p_F_mm = truth.truth.further[k].p_FS_mm;
      const Eigen::Vector3d true_mm =
          truth.truth.X_WB * (forward_kinematics(truth.truth.robot, point.q_actual) * p_F_mm);
      EXPECT_LT((*point.p_WS_mm - true_mm).norm(), 0.2) << "pose " << point.pose << ", " << point.smr;
    }
  }
  static bool shows_arm(const StoredPoint& point) {
    return point.purpose == PointPurpose::Identify || point.purpose == PointPurpose::Validate;
  }
};

TEST_F(ReflectorsCampaignTest, MeasuresAtEachPoseThoseThatTheTrackerSees) {
  const CampaignResult& result = run();
  std::map<int, std::set<std::string>> seen;
  std::map<std::string, int> times;
  for (const StoredPoint& point : result.points) {
    if (!shows_arm(point)) continue;
    EXPECT_TRUE(seen[point.pose].insert(point.smr).second) << "once each";
    ++times[point.smr];
  }
  EXPECT_EQ(seen.size() + result.skipped.size(), 28U);
  std::set<int> poses;
  for (const StoredPoint& point : result.points) poses.insert(point.pose);
  EXPECT_EQ(static_cast<std::size_t>(observer.last.done), poses.size()) << "a pose counts once";
  for (const std::string name : {"a", "b", "c"}) EXPECT_GT(times[name], 3) << name;
  EXPECT_TRUE(std::ranges::any_of(seen, [](const auto& pose) { return pose.second.size() > 1; }));
}

TEST_F(ReflectorsCampaignTest, IdentifiesThemTogetherWithTheArm) {
  config.campaign.remeasure = false;
  const CampaignResult& result = run();
  const Calibration& calibration = result.as<CalibrationResult>().calibration;
  ASSERT_EQ(calibration.cell.reflectors.size(), 3U);
  EXPECT_EQ(calibration.cell.reflectors.front().name, "a");
  const double rms_mm = calibration.validate->after.rms;
  EXPECT_LT(rms_mm, 0.1);
  EXPECT_LT(rms_mm, calibration.validate->before.rms / 5);
  // Between the reflectors nothing else can be: their mutual places come out as they are.
  const auto& found = calibration.cell.reflectors;
  const auto true_b_mm = truth.truth.further[0].p_FS_mm;
  EXPECT_LT(((found[1].p_FS_mm - found[0].p_FS_mm).norm() - (true_b_mm - truth.truth.p_FS_mm).norm()), 0.1);
}

TEST_F(ReflectorsCampaignTest, TellsWhichReflectorWasNotMeasuredAndKeepsThePose) {
  config.campaign.remeasure = false;
  config.campaign.pause_after_lost = 0;
  truth.truth.further[0].acceptance_rad = 15 * kRadPerDeg;  // b is dirty
  const CampaignResult& result = run();
  int reported = 0;
  for (const std::string& sentence : observer.troubles) {
    if (sentence.find("reflector \"b\" was not measured: tracker: no reflector") == std::string::npos)
      continue;
    int pose = 0;
    ASSERT_EQ(std::sscanf(sentence.c_str(), "pose %d:", &pose), 1) << sentence;
    EXPECT_TRUE(std::ranges::count(result.points, pose, &StoredPoint::pose)) << sentence;
    ++reported;
  }
  EXPECT_GT(reported, 0);
}

TEST_F(ReflectorsCampaignTest, TellsOfAPoseThatItGivesUpWhichReflectorsItLookedFor) {
  config.campaign.remeasure = false;
  config.campaign.retries = config.campaign.pause_after_lost = 0;
  observer.at_point = [this](const StoredPoint&) { cell->use_faults({.no_target = 0.6}); };
  start();
  ASSERT_TRUE(go_on());
  std::map<std::string, int> times;
  for (const StoredPoint& wanted : observer.given_up) {
    ++times[wanted.smr];
    const PlannedPose& pose = *std::ranges::find(journal.plan.poses, wanted.pose, &PlannedPose::pose);
    const Eigen::Isometry3d X_WF = truth.truth.X_WB * forward_kinematics(truth.truth.robot, pose.q_commanded);
    const std::string names = ", " + wanted.smr + ",";
    for (const config::ReflectorConfig& each : config::reflectors_of(config)) {
      if (names.find(" " + each.name + ",") == std::string::npos) continue;
      const Eigen::Vector3d to_tracker = -(X_WF * each.p_FS_mm).normalized();
      const double off_deg =
          std::acos(to_tracker.dot(X_WF.linear() * each.facing_F.normalized())) * kDegPerRad;
      EXPECT_LT(off_deg, each.acceptance_deg + 4) << "pose " << wanted.pose << ", " << each.name;
    }
  }
  EXPECT_THAT(times, testing::Contains(testing::Key("c"))) << "the first was not in sight";
  EXPECT_THAT(times, testing::Contains(testing::Key(testing::StartsWith("a, ")))) << "several were";
}

TEST_F(ReflectorsCampaignTest, LeavesOutAReflectorThatWasSeenAtNoPoseToIdentifyFrom) {
  config.campaign.remeasure = false;
  std::vector<StoredPoint> points = run().points;
  std::erase_if(points, [](const StoredPoint& point) {
    return point.smr == "c" && point.purpose == PointPurpose::Identify;
  });
  const auto of_c = std::ranges::count(points, "c", &StoredPoint::smr);
  ASSERT_GT(of_c, 0);
  const CorrectedPoints corrected = corrected_points(points, config);
  EXPECT_EQ(std::ranges::count(corrected.points, "c", &StoredPoint::smr), 0);
  EXPECT_GT(std::ranges::count(corrected.points, PointPurpose::Validate, &StoredPoint::purpose), 5);
  EXPECT_THAT(corrected.findings,
              testing::Contains(testing::Field(
                  &Finding::sentence,
                  testing::StartsWith(
                      "reflector \"c\" was seen at no pose to identify from: what was measured of it (" +
                      std::to_string(of_c)))));
}

TEST_F(ReflectorsCampaignTest, TellsThemApartBeforeItKnowsWhereTheBaseStands) {
  // Farther off than from one reflector to the next.
  truth.truth.X_WB = config.tracker.robot_base * pose_from_kuka({150, -120, 60}, {1.5, -1, 1});
  expect_every_point_where_its_reflector_was();
}

TEST_F(ReflectorsCampaignTest, TakesNoOtherInSightForTheOneThatItLooksFor) {
  truth.truth.X_WB = config.tracker.robot_base * pose_from_kuka({60, -40, 30}, {1, -0.5, 0.5});
  // Close to a, and seen where the cell file says that it is not.
  config.further_reflectors = {{.name = "c",
                                .p_FS_mm = config.reflector.p_FS_mm + Eigen::Vector3d{60, 25, -30},
                                .facing_F = config.reflector.facing_F,
                                .acceptance_deg = 8}};
  truth.truth.further = {{config.further_reflectors[0].p_FS_mm + Eigen::Vector3d{-3, 2, 4},
                          truth.truth.facing_F, truth.truth.acceptance_rad}};
  expect_every_point_where_its_reflector_was();
}

TEST_F(ReflectorsCampaignTest, RemeasuresByTheReflectorsThatAreSeen) {
  const CampaignResult& result = run();
  const CalibrationResult& calibrated = result.as<CalibrationResult>();
  ASSERT_TRUE(calibrated.remeasured);
  EXPECT_LT(calibrated.remeasured->rms, 0.15);
}

TEST_F(ReflectorsCampaignTest, ComesToTheReferenceByTheSameReflectorEachTime) {
  config.campaign.remeasure = false;
  config.campaign.reference_every = 5;
  const CampaignResult& result = run();
  std::set<std::string> names;
  int times = 0;
  for (const StoredPoint& point : result.points) {
    if (point.purpose != PointPurpose::Reference) continue;
    names.insert(point.smr);
    ++times;
  }
  EXPECT_EQ(names.size(), 1U);
  EXPECT_GE(times, 4);
}

TEST_F(ReflectorsCampaignTest, GoesOnWithAllOfThemAfterAnInterruptionInWhichTheTrackerMoved) {
  config.campaign.remeasure = false;
  std::shared_ptr<const CampaignPast> past;
  observer.at_point = [this, &past, n = 0](const StoredPoint&) mutable {
    if (++n != 20) return;
    past = journal.past();
    campaign->abort("cut off");
  };
  start();
  ASSERT_TRUE(go_on());
  observer.at_point = {};
  ASSERT_TRUE(past);
  EXPECT_EQ(past->misfit(config), std::nullopt);
  truth.truth.X_WB = pose_from_kuka({4, -3, 2}, {0.01, 0.02, -0.01}) * truth.truth.X_WB;
  start(CalibrationOrder{}, past);
  ASSERT_TRUE(go_on());
  ASSERT_TRUE(*outcome) << outcome->error().detail;
  const CampaignResult& result = ***outcome;

  ASSERT_EQ(result.resumptions.size(), 1U);
  EXPECT_THAT(result.resumptions.front().found, testing::HasSubstr("has moved"));
  std::set<std::pair<int, std::string>> seen;
  std::map<std::string, int> since;
  for (const StoredPoint& point : result.points) {
    if (!shows_arm(point)) continue;
    EXPECT_TRUE(seen.emplace(point.pose, point.smr).second) << "once each";
    since[point.smr] += point.resumption;
  }
  for (const StoredPoint& point : past->points) EXPECT_TRUE(seen.contains({point.pose, point.smr}));
  for (const std::string name : {"a", "b", "c"}) EXPECT_GT(since[name], 0) << name;
  EXPECT_LT(result.as<CalibrationResult>().calibration.validate->after.rms, 0.1);
}

}  // namespace
}  // namespace truepose::daemon
