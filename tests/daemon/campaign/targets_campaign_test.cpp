#include <gmock/gmock.h>

#include <algorithm>
#include <set>

#include "config/cell_setup.hpp"
#include "core/math/statistics.hpp"
#include "core/plan/candidates.hpp"
#include "tests/daemon/campaign_fixture.hpp"

namespace truepose::daemon {
namespace {

using testing::AllOf;
using testing::Each;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;

/// Drives to targets with a model that is some hundredths of a millimetre off.
struct TargetsTest : CampaignTest {
  TargetsTest()
      : model{truth.truth.robot,
              BasePose::of(truth.truth.X_WB),
              {Reflector{config.reflector.name, truth.truth.p_FS_mm}}},
        targets{draw_candidates(config::scene_of(config), {.poses = 12, .seed = 1}, 12).value().poses} {
    model.robot.joints[1].theta_rad += 2e-5;
    model.robot.joints[2].a_mm += 0.03;
  }

  /// Takes the model that a calibration finds.
  void calibrate() {
    config.campaign.identify_poses = 30;
    config.campaign.remeasure = false;
    start();
    ASSERT_TRUE(go_on() && *outcome);
    model = (***outcome).as<CalibrationResult>().calibration.cell;
  }
  const TargetsResult& drive(TargetsOrder order) {
    order.cell = model;
    start(std::move(order));
    EXPECT_TRUE(go_on());
    EXPECT_TRUE(*outcome) << outcome->error().detail;
    return (***outcome).as<TargetsResult>();
  }
  /// How far the real arm is from a target, stopped there once more.
  Eigen::Vector3d true_error_mm(const TargetOutcome& target) {
    cell->start_motion(truth.q_start, 100);
    at_rest();
    cell->start_motion(target.q, 100);
    at_rest();
    const CalibratedCell asked{config.robot.model, model.base, model.reflectors};
    return cell->p_WS_mm() - asked.predict(target.q_target, 0);
  }
  void at_rest() {
    bool there = false;
    boost::asio::co_spawn(io, clock.sleep_until(cell->motion_ends()),
                          [&](std::exception_ptr) { there = true; });
    EXPECT_TRUE(clock.run(io, [&] { return there; }));
  }

  CalibratedCell model;
  std::vector<JointVector> targets;
};

TEST_F(TargetsTest, FindsTheJointsAtWhichTheRealArmStandsAtItsTargets) {
  calibrate();
  const TargetsResult& result = drive({.targets = targets});
  ASSERT_THAT(result.targets, SizeIs(targets.size()));
  std::vector<Eigen::Vector3d> errors_mm;
  for (std::size_t i = 0; i < targets.size(); ++i) {
    const TargetOutcome& target = result.targets[i];
    EXPECT_EQ(target.q_target, targets[i]);
    EXPECT_TRUE(target.reached) << target.reason;
    EXPECT_THAT(target.reason, IsEmpty());
    EXPECT_LE(target.averaged_error_mm, result.loop.tolerance_mm);
    EXPECT_LE(static_cast<int>(target.errors_mm.size()), result.loop.rounds);
    for (int n = 0; n < 20; ++n) errors_mm.push_back(true_error_mm(target));
  }
  const ErrorStatistics error = error_statistics(errors_mm);
  RecordProperty("mean_mm", std::to_string(error.mean));
  EXPECT_LE(error.mean, 0.030) << "of which the arm's repeatability alone is 0.0265";
}

TEST_F(TargetsTest, APointOfFourReadingsScattersHalfAsMuchAsOne) {
  drive({.targets = targets, .readings = 4});
  ASSERT_FALSE(journal.points.empty());
  for (const StoredPoint& point : journal.points)
    EXPECT_NEAR(point.std_mm.x(), truth.noise.range_mm / 2, 1e-9) << "target " << point.pose;
}

TEST_F(TargetsTest, StoresEveryRoundAsAPointOfItsOwn) {
  const TargetsResult& result = drive({.targets = {targets[0], targets[1]}, .readings = 1});
  const std::size_t rounds = result.targets[0].errors_mm.size() + result.targets[1].errors_mm.size();
  ASSERT_THAT(journal.points, SizeIs(rounds));
  std::set<int> poses;
  for (const StoredPoint& point : journal.points) {
    EXPECT_EQ(point.purpose, PointPurpose::Target);
    poses.insert(point.pose);
  }
  EXPECT_THAT(poses, SizeIs(rounds)) << "each with a number of its own";
  const auto first = std::ranges::count(journal.points, targets[0], &StoredPoint::q_target);
  EXPECT_EQ(static_cast<std::size_t>(first), result.targets[0].errors_mm.size());
  EXPECT_NE(journal.points[0].q_commanded, journal.points[1].q_commanded);
  EXPECT_EQ(campaign->progress().left(), 0) << "rounds that were not needed are not counted";
}

TEST_F(TargetsTest, TakesTheValidationPosesOfAPlanWhereNoneAreGiven) {
  config.campaign.validate_poses = 3;
  const TargetsResult& result = drive({.targets = {}});
  EXPECT_THAT(result.targets, SizeIs(3));
}

TEST_F(TargetsTest, LeavesOutWithAReasonWhereTheArmMayNotGoOrTheTrackerDoesNotSeeIt) {
  JointVector into_the_floor = targets[0], turned_away = targets[0];
  into_the_floor << 0, -0.2, 0.6, 0, 0.5, 0;
  turned_away[0] += turned_away[0] > 0 ? -1.5 : 1.5;
  const TargetsResult& result = drive({.targets = {into_the_floor, targets[0], turned_away}});
  ASSERT_THAT(result.targets, SizeIs(3));
  EXPECT_THAT(result.targets[0].reason, HasSubstr("the pose "));
  EXPECT_EQ(result.targets[0].q.size(), 0);
  EXPECT_TRUE(result.targets[1].reached);
  EXPECT_THAT(result.targets[2].reason, HasSubstr("the pose "));
  EXPECT_THAT(journal.skipped, SizeIs(2));
  EXPECT_EQ(campaign->progress().left(), 0);
}

TEST_F(TargetsTest, SaysOfATargetThatItsRoundsWereNotEnough) {
  const TargetsResult& result =
      drive({.targets = {targets[0]}, .loop = {.rounds = 2, .tolerance_mm = 0}, .readings = 1});
  EXPECT_FALSE(result.targets[0].reached);
  EXPECT_THAT(result.targets[0].reason, HasSubstr("after 2 rounds"));
  EXPECT_EQ(result.targets[0].q.size(), 6) << "what was found is still the best there is";
}

TEST_F(TargetsTest, GoesOnWithTheNextTargetWhereOneIsNotMeasured) {
  truth.faults.tracker_busy = 0.15;
  config.campaign.pause_after_lost = 0;
  config.campaign.retries = 0;
  const TargetsResult& result = drive({.targets = targets});
  EXPECT_THAT(result.targets, SizeIs(targets.size()));
  EXPECT_FALSE(journal.skipped.empty());
  for (const TargetOutcome& target : result.targets) EXPECT_EQ(target.reached, target.reason.empty());
  EXPECT_EQ(campaign->progress().left(), 0);
}

TEST_F(TargetsTest, ComesToATargetFromTheSameSideInEveryRound) {
  config.campaign.approach = config::ApproachSide::Alternate;
  drive({.targets = {targets[0], targets[1]}});
  for (const StoredPoint& point : journal.points)
    EXPECT_THAT(point.direction, AllOf(SizeIs(6), Each(point.q_target == targets[0] ? 1 : -1)));
}

}  // namespace
}  // namespace truepose::daemon
