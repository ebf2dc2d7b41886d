#include <gmock/gmock.h>

#include <algorithm>
#include <boost/asio/co_spawn.hpp>
#include <boost/asio/post.hpp>
#include <optional>
#include <set>

#include "core/arm/forward.hpp"
#include "core/math/angles.hpp"
#include "tests/daemon/campaign_fixture.hpp"

namespace truepose::daemon {
namespace {

namespace asio = boost::asio;
using namespace std::chrono_literals;
using testing::AllOf;
using testing::Contains;
using testing::Each;
using testing::ElementsAre;
using testing::Ge;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Lt;
using testing::Ne;
using testing::SizeIs;

TEST_F(CampaignTest, CalibratesTheArmAndShowsByMeasuringAgainThatCompensationWorks) {
  config.campaign.identify_poses = 30;
  config.campaign.validate_poses = 30;
  start();
  ASSERT_TRUE(go_on());
  ASSERT_TRUE(*outcome) << outcome->error().detail;
  const CampaignResult& result = ***outcome;
  EXPECT_THAT(observer.troubles, IsEmpty());
  EXPECT_EQ(result.points.size(), 90U);
  EXPECT_EQ(journal.points.size(), 90U);
  EXPECT_THAT(result.skipped, IsEmpty());
  EXPECT_EQ(journal.begun, 1);
  EXPECT_EQ(journal.ended, 1);
  EXPECT_EQ(journal.result, **outcome);
  EXPECT_THAT(observer.phases,
              ElementsAre(CampaignPhase::Connect, CampaignPhase::Plan, CampaignPhase::WarmUp,
                          CampaignPhase::Identify, CampaignPhase::Validate, CampaignPhase::Compute,
                          CampaignPhase::Remeasure, CampaignPhase::Finish));
  ASSERT_TRUE(result.as<CalibrationResult>().calibration.validate);
  EXPECT_FALSE(result.as<CalibrationResult>().verdict.failed());
  EXPECT_GT(result.as<CalibrationResult>().calibration.validate->before.mean, 1.0);
  EXPECT_LT(result.as<CalibrationResult>().calibration.validate->geometric.mean, 0.06);
  ASSERT_TRUE(result.as<CalibrationResult>().remeasured);
  EXPECT_EQ(result.as<CalibrationResult>().remeasured->count, 30);
  EXPECT_LT(result.as<CalibrationResult>().remeasured->mean, 0.06);
  EXPECT_EQ(observer.last.done, 90);
  EXPECT_EQ(observer.last.time_left_s, 0);
}

TEST_F(CampaignTest, LooksWhereTheReflectorIsOnceTheFirstPosesHaveShownIt) {
  start();
  ASSERT_TRUE(go_on());
  const auto coarse_after = static_cast<std::size_t>(config.campaign.coarse_after);
  for (std::size_t i = 0; i < observer.deviations_mm.size(); ++i) {
    if (i >= coarse_after && i < 2 * coarse_after) continue;
    if (i < coarse_after) {
      EXPECT_GT(observer.deviations_mm[i], 25) << i;
    } else {
      EXPECT_LT(observer.deviations_mm[i], 25) << i;
    }
  }
}

TEST_F(CampaignTest, IdentifiesByTheOrientationsOfA6DTargetToo) {
  start();
  ASSERT_TRUE(go_on());
  ASSERT_TRUE(*outcome) << outcome->error().detail;
  const Calibration by_positions = (***outcome).as<CalibrationResult>().calibration;
  EXPECT_FALSE(by_positions.mountings.front()) << "a plain reflector has no orientation";
  truth.orientation_sigma_rad = 5e-5;
  truth.truth.R_FT = rotation_zyx(0.3, -0.2, 1.1);
  start();
  ASSERT_TRUE(go_on());
  ASSERT_TRUE(*outcome) << outcome->error().detail;
  const Calibration& by_poses = (***outcome).as<CalibrationResult>().calibration;
  ASSERT_THAT(by_poses.mountings, testing::SizeIs(1));
  ASSERT_TRUE(by_poses.mountings.front());
  // The zero of the last joint and the mounting are not separable: how the target stands at a pose is.
  const JointVector& q = journal.points.front().q_actual;
  const auto stands = [&](const Eigen::Isometry3d& X_WB, const RobotModel& arm, const Eigen::Matrix3d& R_FT) {
    return Eigen::Matrix3d(X_WB.linear() * forward_kinematics(arm, q).linear() * R_FT);
  };
  EXPECT_LT(angle_between(
                stands(by_poses.cell.base.isometry(), by_poses.cell.robot, by_poses.mountings.front()->R_FT),
                stands(truth.truth.X_WB, truth.truth.robot, truth.truth.R_FT)),
            10 * by_poses.mountings.front()->sigma_rad);
}

/// Takes its time to write, and looks at the arm meanwhile.
struct SlowJournal final : CampaignJournal {
  SlowJournal(drivers::Clock& c, std::optional<drivers::MockCell>& m) : clock{c}, cell{m} {}
  asio::awaitable<StoreResult<std::string>> begin(int) override { co_return std::string{}; }
  asio::awaitable<StoreResult<void>> know(Identities) override { co_return StoreResult<void>{}; }
  asio::awaitable<StoreResult<void>> add_planned(std::vector<PlannedPose>, int) override {
    co_return StoreResult<void>{};
  }
  asio::awaitable<StoreResult<void>> add_identified(std::string) override { co_return StoreResult<void>{}; }
  asio::awaitable<StoreResult<void>> add_resumption(Resumption) override { co_return StoreResult<void>{}; }
  asio::awaitable<StoreResult<StoredPoint>> add_point(StoredPoint point) override {
    const TimePoint written = clock.now() + 20s;
    co_await clock.sleep_until(written);
    ++points;
    EXPECT_EQ(cell->q(), point.q_actual) << "the arm moved on before point " << points << " was on the disk";
    co_return point;
  }
  asio::awaitable<StoreResult<void>> add_skipped(SkippedPose) override { co_return StoreResult<void>{}; }
  asio::awaitable<StoreResult<void>> end(std::shared_ptr<const CampaignResult>,
                                         std::optional<CampaignError>) override {
    co_return StoreResult<void>{};
  }
  drivers::Clock& clock;
  std::optional<drivers::MockCell>& cell;
  int points = 0;
};

TEST_F(CampaignTest, StoresEachPointBeforeTheArmMovesOn) {
  SlowJournal slow{clock, cell};
  cell.emplace(truth, clock);
  robot.emplace(*cell);
  tracker.emplace(*cell);
  campaign.emplace(config, CampaignDevices{*robot, *tracker, clock}, slow, observer, &test::compute_here);
  asio::co_spawn(io, campaign->run(),
                 [this](std::exception_ptr, Outcome ended) { outcome.emplace(std::move(ended)); });
  ASSERT_TRUE(go_on());
  EXPECT_EQ(slow.points, 40);
}

TEST_F(CampaignTest, RefusesAnArmOfAnotherTypeBeforeItMoves) {
  truth.robot_model = "#KR16R2010_2 C4 FLR";
  start();
  ASSERT_TRUE(go_on());
  ASSERT_FALSE(*outcome);
  EXPECT_EQ(outcome->error().fault, CampaignFault::WrongArm);
  EXPECT_THAT(outcome->error().detail, HasSubstr("#KR16R2010_2"));
  EXPECT_EQ(cell->q(), truth.q_start);
  EXPECT_EQ(journal.begun, 1);
  EXPECT_EQ(journal.ended, 1);
}

TEST_F(CampaignTest, RefusesAnArmWhoseControllerComputesOtherPoses) {
  truth.nominal.joints[3].d_mm += 300;
  start();
  ASSERT_TRUE(go_on());
  ASSERT_FALSE(*outcome);
  EXPECT_EQ(outcome->error().fault, CampaignFault::WrongArm);
  EXPECT_THAT(outcome->error().detail, HasSubstr("300.00 mm apart"));
  EXPECT_EQ(cell->q(), truth.q_start);
}

TEST_F(CampaignTest, SkipsPosesThatFailEveryTimeAndEndsOnceNoFitCanSucceedAnyMore) {
  truth.faults.tracker_busy = 1;
  config.campaign.pause_after_lost = 0;
  start();
  ASSERT_TRUE(go_on());
  ASSERT_FALSE(*outcome);
  EXPECT_EQ(outcome->error().fault, CampaignFault::Calibration);
  EXPECT_TRUE(journal.points.empty());
  ASSERT_EQ(journal.skipped.size(), 7U);
  EXPECT_EQ(journal.skipped[3].pose, 4);
  EXPECT_EQ(journal.skipped[3].attempts, 3);
  EXPECT_THAT(journal.skipped[3].reason, HasSubstr("the tracker is busy"));
  EXPECT_THAT(
      outcome->error().detail,
      HasSubstr("too many poses were lost: of those to identify from, 9 are too few for the parameters"));
  EXPECT_EQ(campaign->progress().skipped, 7) << "16 poses were planned, 10 are needed";
  EXPECT_THAT(observer.phases, Each(Ne(CampaignPhase::Validate)));
}

TEST_F(CampaignTest, CountsPosesThatAreMeasuredThatWereSkippedAndThatAreLeft) {
  truth.faults.tracker_busy = 0.5;
  config.campaign.pause_after_lost = 0;
  start();
  observer.at_point = [&](const StoredPoint&) {
    const CampaignProgress now = campaign->progress();
    EXPECT_EQ(now.done, std::ssize(journal.points));
    EXPECT_EQ(now.skipped, std::ssize(journal.skipped));
    EXPECT_EQ(now.done + now.skipped + now.left(), now.total);
  };
  ASSERT_TRUE(go_on());
  EXPECT_FALSE(journal.skipped.empty());
}

TEST_F(CampaignTest, TellsOfAPoseThatItGivesUpWhatItWasFor) {
  config.campaign.reference_every = 5;
  config.campaign.pause_after_lost = config.campaign.retries = 0;
  observer.at_point = [this](const StoredPoint&) { cell->use_faults({.tracker_busy = 0.3}); };
  start();
  ASSERT_TRUE(go_on());
  ASSERT_EQ(observer.given_up.size(), journal.skipped.size());
  std::set<PointPurpose> purposes;
  for (const StoredPoint& wanted : observer.given_up) {
    const auto planned = std::ranges::find(journal.plan.poses, wanted.pose, &PlannedPose::pose);
    ASSERT_NE(planned, journal.plan.poses.end());
    EXPECT_EQ(wanted.purpose, planned->purpose) << "pose " << wanted.pose;
    EXPECT_EQ(wanted.smr, "1");
    EXPECT_FALSE(wanted.p_WS_mm);
    purposes.insert(wanted.purpose);
  }
  EXPECT_THAT(purposes, testing::IsSupersetOf({PointPurpose::Identify, PointPurpose::Validate,
                                               PointPurpose::Remeasure, PointPurpose::Reference}));
}

TEST_F(CampaignTest, SaysOfAPoseThatTakesLongThatTheEndGetsNoNearer) {
  start();
  observer.at_point = [this](const StoredPoint& point) {
    if (point.pose == 5) robot->leave(1h);
    if (point.pose == 5) robot->disconnect();
  };
  std::vector<double> left_s;
  for (const Duration time : {10min, 20min, 30min})
    at(time, [&] { left_s.push_back(campaign->progress().time_left_s.value()); });
  ASSERT_TRUE(go_on());
  ASSERT_TRUE(*outcome);
  EXPECT_NEAR(left_s[1] - left_s[0], 600, 1);
  EXPECT_NEAR(left_s[2] - left_s[1], 600, 1);
}

TEST_F(CampaignTest, APoseThatFailsIsReplacedByAnother) {
  config.campaign.retries = config.campaign.pause_after_lost = 0;
  observer.at_point = [this](const StoredPoint&) { cell->use_faults({.tracker_busy = 0.1}); };
  start();
  ASSERT_TRUE(go_on());
  ASSERT_TRUE(*outcome) << outcome->error().detail;
  const auto count = [&](PointPurpose purpose) {
    return std::ranges::count(journal.points, purpose, &StoredPoint::purpose);
  };
  EXPECT_FALSE(journal.skipped.empty());
  EXPECT_EQ(count(PointPurpose::Identify), config.campaign.identify_poses);
  EXPECT_EQ(count(PointPurpose::Validate), config.campaign.validate_poses);
  EXPECT_THAT(observer.troubles, Contains(HasSubstr("is replaced by pose")));
  EXPECT_EQ(campaign->progress().left(), 0);
}

TEST_F(CampaignTest, MeasuresTheReferencePoseAgainAndAgain) {
  config.campaign.reference_every = 5;
  start();
  ASSERT_TRUE(go_on());
  ASSERT_TRUE(*outcome) << outcome->error().detail;
  std::vector<JointVector> references;
  for (const StoredPoint& point : journal.points)
    if (point.purpose == PointPurpose::Reference) references.push_back(point.q_target);
  EXPECT_THAT(
      references,
      AllOf(SizeIs(6), Each(references.front())));  // 16 poses: before 0, 5, 10, 15, and last; validated
  for (const StoredPoint& point : journal.points) {
    if (point.purpose == PointPurpose::Reference) {
      EXPECT_THAT(point.direction, AllOf(SizeIs(6), Each(1)));
    }
  }
  const CampaignResult& result = ***outcome;
  EXPECT_THAT(result.as<CalibrationResult>().reference_drift_mm, SizeIs(6));
  EXPECT_EQ(campaign->progress().left(), 0);
  EXPECT_THAT(result.as<CalibrationResult>().reference_drift_mm, Each(AllOf(Ge(0), Lt(0.2))));
  EXPECT_EQ(measurement_data(result.points, "1").points.size(), 28U) << "the reference identifies nothing";
}

TEST_F(CampaignTest, ComesToEveryPoseFromTheConfiguredSide) {
  config.campaign.approach = config::ApproachSide::Upwards;
  start();
  ASSERT_TRUE(go_on());
  ASSERT_TRUE(*outcome) << outcome->error().detail;
  for (const StoredPoint& point : journal.points) EXPECT_THAT(point.direction, AllOf(SizeIs(6), Each(1)));
}

TEST_F(CampaignTest, ComesFromBothSidesInTurnSoThatBacklashShows) {
  config.campaign.approach = config::ApproachSide::Alternate;
  start();
  ASSERT_TRUE(go_on());
  ASSERT_TRUE(*outcome) << outcome->error().detail;
  for (const StoredPoint& point : journal.points)
    EXPECT_THAT(point.direction, Each(point.pose % 2 == 1 ? 1 : -1)) << point.pose;
  for (const Measurement& point : measurement_data((***outcome).points, "1").points)
    EXPECT_THAT(point.direction, SizeIs(6));
}

TEST_F(CampaignTest, CorrectsWhatTheJointsDoBeyondGeometryWhereThatIsAskedFor) {
  truth.truth.non_geometric = heavy_arm_errors({.backlash_rad = 0.002 * kRadPerDeg});
  config.campaign.identify_poses = 60;
  config.campaign.candidates = 200;
  config.campaign.approach = config::ApproachSide::Alternate;
  config.calibration.non_geometric = true;
  start();
  ASSERT_TRUE(go_on());
  ASSERT_TRUE(*outcome) << outcome->error().detail;
  const CampaignResult& result = ***outcome;
  ASSERT_TRUE(result.as<CalibrationResult>().calibration.validate &&
              result.as<CalibrationResult>().remeasured);
  const double geometric_mm = result.as<CalibrationResult>().calibration.validate->geometric.mean;
  EXPECT_GT(geometric_mm, 0.2) << "or the arm shows nothing";
  EXPECT_LT(result.as<CalibrationResult>().calibration.validate->after.mean, geometric_mm / 4);
  EXPECT_LT(result.as<CalibrationResult>().remeasured->mean, geometric_mm / 4)
      << "the corrected arm, measured";
}

TEST_F(CampaignTest, TheReferencePoseShowsAnArmThatWarmsUp) {
  config.campaign.reference_every = 5;
  truth.truth.warm_up = {.zero = JointVector::Constant(6, 6e-4), .time_constant = Seconds{1200}};
  start();
  ASSERT_TRUE(go_on() && *outcome);
  const std::vector<double>& drift_mm = (***outcome).as<CalibrationResult>().reference_drift_mm;
  ASSERT_FALSE(drift_mm.empty());
  EXPECT_GT(drift_mm.back(), 0.2);
}

TEST_F(CampaignTest, DoesNotCompensateWithACalibrationThatIsNoBetterThanTheDataSheet) {
  truth.truth.robot = truth.nominal;
  truth.noise.range_mm = truth.noise.transverse_mm = 0.5;
  config.tracker.noise = truth.noise;
  config.campaign.identify_poses = 10;  // hardly more equations than unknowns: all of it goes into the arm
  start();
  ASSERT_TRUE(go_on());
  ASSERT_TRUE(*outcome) << outcome->error().detail;
  EXPECT_THAT((**outcome)->as<CalibrationResult>().verdict.findings,
              Contains(testing::Field(&Finding::sentence, HasSubstr("no better than the nominal"))));
  EXPECT_FALSE((**outcome)->as<CalibrationResult>().remeasured);
  EXPECT_EQ(journal.points.size(), 22U);
  ASSERT_EQ(journal.skipped.size(), 12U);
  EXPECT_THAT(journal.skipped[0].reason, HasSubstr("no better"));
}

TEST_F(CampaignTest, EndsWhereAnotherReflectorWasTakenForOursInTheFirstPoses) {
  truth.faults.wrong_reflector = 0.3;
  start();
  ASSERT_TRUE(go_on());
  ASSERT_FALSE(*outcome);
  EXPECT_EQ(outcome->error().fault, CampaignFault::Calibration);
  EXPECT_THAT(outcome->error().detail, HasSubstr("do not fit the nominal arm"));
}

TEST_F(CampaignTest, APointFarFromItsPredictionIsAWrongReflectorAndNoMeasurement) {
  truth.faults.wrong_reflector = 1;
  cell.emplace(truth, clock);
  robot.emplace(*cell);
  tracker.emplace(*cell);
  CellDevices devices{config, {*robot, *tracker, clock}, [](const std::string&) {}};
  std::optional<std::expected<CellDevices::MeasureResult, DeviceError>> point;
  const auto measure = [&]() -> asio::awaitable<void> {
    auto connected = co_await devices.connect();
    EXPECT_TRUE(connected);
    const CellDevices::MeasureRequest request{.p_W_mm = cell->p_WS_mm(), .search_mm = 300, .gate_mm = 25};
    auto measured = co_await devices.measure(request);
    point.emplace(std::move(measured));
  };
  asio::co_spawn(io, measure, [](std::exception_ptr e) { EXPECT_FALSE(e); });
  ASSERT_TRUE(clock.run(io, [&] { return point.has_value(); }));
  ASSERT_FALSE(*point);
  EXPECT_THAT(point->error().detail, HasSubstr("wrong reflector"));
}

}  // namespace
}  // namespace truepose::daemon
