// Campaigns that continue after the daemon has ended. What a power cut leaves is what the journal has: a
// campaign is cut off at some moment, and another begins with that alone.

#include <gmock/gmock.h>

#include <algorithm>
#include <boost/asio/post.hpp>
#include <map>
#include <set>

#include "config/model_file.hpp"
#include "core/math/angles.hpp"
#include "tests/daemon/campaign_fixture.hpp"

namespace truepose::daemon {
namespace {

using testing::AllOf;
using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::SizeIs;

constexpr int kIdentified = 16, kValidated = 28,
              kRemeasured = 40;  // points, in a cell without a reference pose

struct ResumedCampaignTest : CampaignTest {
  using Past = std::shared_ptr<const CampaignPast>;

  /// Cuts the campaign off once it has measured so many points.
  Past cut_at_point(int points, CampaignOrder order = CalibrationOrder{}, Past before = {}) {
    Past past;
    observer.at_point = [this, &past, points, n = 0](const StoredPoint&) mutable {
      if (++n == points) cut(past);
    };
    start(std::move(order), before);
    return to_the_cut(past, before);
  }
  /// Or as soon as it comes to a phase.
  Past cut_in(CampaignPhase phase, Past before = {}) {
    Past past;
    observer.at_phase = [this, &past, phase](CampaignPhase now) {
      if (now == phase) cut(past);
    };
    start(CalibrationOrder{}, before);
    return to_the_cut(past, before);
  }
  const CampaignResult& go_on_with(Past past, CampaignOrder order = CalibrationOrder{}) {
    start(std::move(order), past);
    EXPECT_TRUE(go_on());
    if (!*outcome) throw std::runtime_error{outcome->error().detail};
    return ***outcome;
  }
  CampaignError refused(Past past) {
    start(CalibrationOrder{}, past);
    EXPECT_TRUE(go_on());
    EXPECT_FALSE(*outcome);
    return *outcome ? CampaignError{} : outcome->error();
  }
  /// As if neither the tracker nor the arm had any scatter, but its gears: the same campaign measures the
  /// same, and is left with as much as another is by noise.
  void without_chance() {
    truth.noise = {};
    truth.truth.repeatability_mm = 0;
    for (int joint = 0; joint < 6; ++joint)
      truth.truth.non_geometric.drives.push_back({.harmonics = {{{1e-5, 1.0 * joint}, {2e-5, 2.0 * joint}}}});
  }
  static std::string model_of(const CampaignResult& result) {
    const Calibration& found = result.as<CalibrationResult>().calibration;
    config::ModelFile file;
    file.cell = found.cell;
    file.parameters = found.parameters;
    file.covariance = found.covariance;
    return config::model_yaml(file);
  }
  static std::vector<std::string> sentences(const CampaignResult& result) {
    std::vector<std::string> all;
    for (const Finding& finding : result.as<CalibrationResult>().verdict.findings)
      all.push_back(finding.sentence);
    return all;
  }
  /// Poses with their purposes, and where the tracker saw them.
  static std::map<int, std::pair<PointPurpose, Eigen::Vector3d>> poses_of(const CampaignResult& result) {
    std::map<int, std::pair<PointPurpose, Eigen::Vector3d>> poses;
    for (const StoredPoint& point : result.points) {
      if (!is_pose(point.purpose)) continue;
      EXPECT_TRUE(poses.emplace(point.pose, std::pair{point.purpose, *point.p_WS_mm}).second) << point.pose;
    }
    return poses;
  }

 private:
  void cut(Past& past) {
    if (past) return;
    past = journal.past();
    // Not before it has waited for anything, which Asio has no answer to.
    if (observer.phases.back() == CampaignPhase::Connect)
      boost::asio::post(io, [this] { campaign->abort("cut off"); });
    else
      campaign->abort("cut off");
  }
  Past to_the_cut(Past& past, const Past& before) {
    EXPECT_TRUE(go_on());
    observer.at_point = {};
    observer.at_phase = {};
    EXPECT_TRUE(past) << "it ended before: " << (*outcome ? "" : outcome->error().detail);
    if (!before) return past;
    auto all = std::make_shared<CampaignPast>(*before);
    all->plan.poses.insert(all->plan.poses.end(), past->plan.poses.begin(), past->plan.poses.end());
    all->points.insert(all->points.end(), past->points.begin(), past->points.end());
    all->skipped.insert(all->skipped.end(), past->skipped.begin(), past->skipped.end());
    all->resumptions.insert(all->resumptions.end(), past->resumptions.begin(), past->resumptions.end());
    if (all->plan.identified.empty()) all->plan.identified = past->plan.identified;
    return all;
  }
};

TEST_F(ResumedCampaignTest, ComesToTheSameAtWhateverPointItWasCutOff) {
  without_chance();
  start();
  ASSERT_TRUE(go_on());
  ASSERT_TRUE(*outcome) << outcome->error().detail;
  const std::string model = model_of(***outcome);
  const auto poses = poses_of(***outcome);
  ASSERT_EQ(poses.size(), 40U);
  for (const int points : {1, 2, 5, 9, kIdentified - 1, kIdentified, 20, kValidated, 33, kRemeasured - 1}) {
    SCOPED_TRACE(points);
    const Past past = cut_at_point(points);
    observer.troubles.clear();
    const CampaignResult& result = go_on_with(past);
    EXPECT_EQ(poses_of(result), poses);
    EXPECT_EQ(model_of(result), model);
    EXPECT_EQ(result.as<CalibrationResult>().remeasured->count, 12);
    EXPECT_EQ(static_cast<int>(journal.points.size()), 40 - points + std::min(points, 2))
        << "two were measured again";
    EXPECT_EQ(campaign->progress().done, 40);
    EXPECT_EQ(campaign->progress().left(), 0);
    EXPECT_THAT(observer.troubles, ElementsAre(HasSubstr("nothing has moved")));
    EXPECT_THAT(sentences(result),
                Contains(AllOf(HasSubstr("the campaign was interrupted (2026-02-03T07:30:00Z) and resumed"),
                               HasSubstr("nothing has moved"))));
  }
}

TEST_F(ResumedCampaignTest, ComesToTheSameInWhateverPhaseItWasCutOff) {
  without_chance();
  start();
  ASSERT_TRUE(go_on() && *outcome);
  const std::string model = model_of(***outcome);
  const auto poses = poses_of(***outcome);
  for (const CampaignPhase phase :
       {CampaignPhase::Connect, CampaignPhase::Plan, CampaignPhase::WarmUp, CampaignPhase::Identify,
        CampaignPhase::Validate, CampaignPhase::Compute, CampaignPhase::Remeasure, CampaignPhase::Finish}) {
    SCOPED_TRACE(phase_name(phase));
    const CampaignResult& result = go_on_with(cut_in(phase));
    EXPECT_EQ(poses_of(result).size(), poses.size());
    // Where there was no plan yet another is made, from where the arm stands now.
    if (phase > CampaignPhase::Plan) {
      EXPECT_EQ(model_of(result), model);
      EXPECT_EQ(poses_of(result), poses);
    }
  }
}

TEST_F(ResumedCampaignTest, GoesOnAfterAnyNumberOfInterruptions) {
  without_chance();
  start();
  ASSERT_TRUE(go_on() && *outcome);
  const auto poses = poses_of(***outcome);
  Past past = cut_at_point(4);
  for (const int more : {7, 9, 11}) past = cut_at_point(more, CalibrationOrder{}, past);
  const CampaignResult& result = go_on_with(past);
  EXPECT_EQ(poses_of(result), poses);
  EXPECT_THAT(result.resumptions, SizeIs(4));
  EXPECT_THAT(sentences(result), Contains(HasSubstr("the campaign was interrupted")).Times(4));
}

TEST_F(ResumedCampaignTest, IsMeasuredByAnArmThatIsWarmAgain) {
  config.campaign.warm_up_moves = 5;
  const Past past = cut_at_point(20);
  observer.phases.clear();
  go_on_with(past);
  EXPECT_THAT(observer.phases,
              ElementsAre(CampaignPhase::Connect, CampaignPhase::Plan, CampaignPhase::Identify,
                          CampaignPhase::Validate, CampaignPhase::WarmUp, CampaignPhase::Validate,
                          CampaignPhase::Compute, CampaignPhase::Remeasure, CampaignPhase::Finish));
}

TEST_F(ResumedCampaignTest, BringsWhatFollowsToWhereATrackerStoodThatWasMovedMeanwhile) {
  config.campaign.identify_poses = 20;
  const Eigen::Isometry3d X_WB = truth.truth.X_WB;
  for (const int points : {10, 26, 36}) {
    SCOPED_TRACE(points);
    truth.truth.X_WB = X_WB;
    const Past past = cut_at_point(points);
    truth.truth.X_WB = pose_from_kuka({3, -3.5, 2}, {0.02, -0.01, 0.015}) * X_WB;
    const CampaignResult& result = go_on_with(past);
    ASSERT_THAT(result.resumptions, SizeIs(1));
    EXPECT_THAT(result.resumptions[0].found, HasSubstr("the tracker or the base has moved by"));
    const auto& found = result.as<CalibrationResult>();
    EXPECT_FALSE(found.verdict.failed()) << testing::PrintToString(sentences(result));
    EXPECT_LT(found.calibration.validate->after.mean, 0.09);
    EXPECT_LT(found.remeasured->mean, 0.09);
    const Eigen::Vector3d base_mm = found.calibration.cell.base.p_mm;
    EXPECT_LT((base_mm - X_WB.translation()).norm(), 2) << "as the first stand saw it";
    EXPECT_GT((base_mm - truth.truth.X_WB.translation()).norm(), 3);
  }
}

TEST_F(ResumedCampaignTest, MeasuresNestsAgainAndGoesByThem) {
  truth.instrument.nests_mm = {{1500, -1400, -800}, {1800, 1500, -700}, {3200, -300, -1200}};
  config.tracker.nests_mm = truth.instrument.nests_mm;
  config.campaign.remeasure = false;
  const Past past = cut_at_point(14);
  start(CalibrationOrder{}, past);
  cell->bump_tracker({4, -3, 1});
  ASSERT_TRUE(go_on());
  ASSERT_TRUE(*outcome) << outcome->error().detail;
  const CampaignResult& result = ***outcome;
  EXPECT_THAT(result.resumptions[0].found, HasSubstr("the tracker or the base has moved by 5."));
  EXPECT_FALSE(result.as<CalibrationResult>().verdict.failed()) << testing::PrintToString(sentences(result));
  EXPECT_LT(result.as<CalibrationResult>().calibration.validate->after.mean, 0.07);
  const auto checks = std::ranges::count(result.points, PointPurpose::Check, &StoredPoint::purpose);
  EXPECT_EQ(checks, 3 + 8) << "the nests and eight poses";
}

TEST_F(ResumedCampaignTest, StaysInterruptedWhereNoMotionOfTheTrackerExplainsWhatIsSeen) {
  const Past past = cut_at_point(20);
  truth.truth.p_FS_mm += Eigen::Vector3d{1.5, -2, 0.5};
  const CampaignError error = refused(past);
  EXPECT_TRUE(error.interrupted);
  EXPECT_THAT(error.detail,
              AllOf(HasSubstr("no motion of the tracker explains that"), HasSubstr("reflector")));
}

TEST_F(ResumedCampaignTest, SaysWhereTooLittleIsThereToTellWhatHasMoved) {
  const Past past = cut_at_point(2);
  truth.truth.X_WB.translation() += Eigen::Vector3d{3, 3, 3};
  const CampaignError error = refused(past);
  EXPECT_TRUE(error.interrupted);
  EXPECT_THAT(error.detail, HasSubstr("abort the campaign and start it again"));
}

TEST_F(ResumedCampaignTest, LooksTwiceWhereTwoPosesAloneSeemToHaveMoved) {
  const Past past = cut_at_point(2);
  start(CalibrationOrder{}, past);
  const Eigen::Vector3d seemingly_mm{0.1, 0.1, 0.1};
  cell->bump_tracker(seemingly_mm);
  journal.at_point = [&, checks = 0](const StoredPoint& point) mutable {
    if (point.purpose == PointPurpose::Check && ++checks == 2) cell->bump_tracker(-seemingly_mm);
  };
  ASSERT_TRUE(go_on());
  ASSERT_TRUE(*outcome) << outcome->error().detail;
  const CampaignResult& result = ***outcome;
  EXPECT_THAT(result.resumptions[0].found, HasSubstr("nothing has moved: 2 poses measured again are within"));
  EXPECT_TRUE(result.resumptions[0].X_first_now.matrix() == Eigen::Matrix4d::Identity());
  const auto checks = std::ranges::count(result.points, PointPurpose::Check, &StoredPoint::purpose);
  EXPECT_EQ(checks, 2 + 2);
}

TEST_F(ResumedCampaignTest, TakesNoSecondLookForStandingStillWhereTheNestsHaveMoved) {
  truth.instrument.nests_mm = {{1500, -1400, -800}, {1800, 1500, -700}, {3200, -300, -1200}};
  config.tracker.nests_mm = truth.instrument.nests_mm;
  const Past past = cut_at_point(2);
  start(CalibrationOrder{}, past);
  cell->bump_tracker({4, -3, 1});
  ASSERT_TRUE(go_on());
  ASSERT_FALSE(*outcome);
  EXPECT_TRUE(outcome->error().interrupted);
  EXPECT_THAT(outcome->error().detail, HasSubstr("are too few to show what has moved"));
}

TEST_F(ResumedCampaignTest, StaysInterruptedWhereTheReflectorIsNotSeen) {
  const Past past = cut_at_point(20);
  truth.faults.no_target = 1;
  const CampaignError error = refused(past);
  EXPECT_TRUE(error.interrupted);
  EXPECT_THAT(error.detail, HasSubstr("let the tracker see the reflector, then resume"));
  truth.faults = {};
  go_on_with(past);
}

TEST_F(ResumedCampaignTest, KnowsWhichPosesWereSkippedAndReplaced) {
  config.campaign.retries = config.campaign.pause_after_lost = 0;
  config.campaign.remeasure = false;
  truth.faults.tracker_busy = 0.15;
  const Past past = cut_at_point(22);
  ASSERT_FALSE(past->skipped.empty());
  const CampaignResult& result = go_on_with(past);
  EXPECT_GE(result.skipped.size(), past->skipped.size());
  std::set<int> numbers;
  for (const auto& [pose, seen] : poses_of(result)) numbers.insert(pose);
  for (const SkippedPose& pose : result.skipped) EXPECT_TRUE(numbers.insert(pose.pose).second) << pose.pose;
  EXPECT_EQ(*numbers.rbegin(), static_cast<int>(numbers.size())) << "a pose has neither";
  for (const auto& [pose, seen] : poses_of(result)) {
    const StoredPoint* before = past->point(pose, seen.first);
    if (before != nullptr) {
      EXPECT_EQ(before->p_WS_mm, seen.second);
    }
  }
}

TEST_F(ResumedCampaignTest, SaysWhichPoseNoLongerFitsTheCellFile) {
  const Past past = cut_at_point(10);
  EXPECT_FALSE(past->misfit(config));
  config::CellConfig lower = config;
  lower.workspace.max_mm.z() = 900;
  EXPECT_THAT(past->misfit(lower).value(), AllOf(HasSubstr("pose "), HasSubstr("of the plan")));
  config::CellConfig other = config;
  other.reflector.name = "big";
  EXPECT_THAT(past->misfit(other).value(), HasSubstr("reflector '1' was measured"));
  other = config;
  other.tracker.nests_mm.resize(3);
  EXPECT_THAT(past->misfit(other).value(), HasSubstr("the cell had 0 nests"));
  other = config;
  other.robot.model.joints.pop_back();
  EXPECT_THAT(past->misfit(other).value(), HasSubstr("has 6 joints"));
}

TEST_F(ResumedCampaignTest, AnOperatorMayAbortOneThatGoesOn) {
  const Past past = cut_at_point(10);
  observer.at_phase = [this](CampaignPhase phase) {
    if (phase == CampaignPhase::WarmUp) campaign->abort("asked for by an operator");
  };
  const CampaignError error = refused(past);
  EXPECT_EQ(error.fault, CampaignFault::Aborted);
  EXPECT_FALSE(error.interrupted);
}

TEST_F(ResumedCampaignTest, DrivesToTheTargetsThatAreLeft) {
  without_chance();
  CalibratedCell model{truth.truth.robot,
                       BasePose::of(truth.truth.X_WB),
                       {Reflector{config.reflector.name, truth.truth.p_FS_mm}}};
  model.robot.joints[1].theta_rad += 2e-5;
  config.campaign.validate_poses = 4;
  TargetsOrder order;
  order.cell = model;
  order.loop.tolerance_mm = 1e-4;
  start(order);
  ASSERT_TRUE(go_on());
  ASSERT_TRUE(*outcome) << outcome->error().detail;
  const auto poses = poses_of(***outcome);
  const TargetsResult& undisturbed = (***outcome).as<TargetsResult>();
  ASSERT_GT(poses.size(), 5U);
  std::vector<JointVector> found;
  for (const TargetOutcome& target : undisturbed.targets) found.push_back(target.q);
  for (const int points : {1, 3, 5}) {
    SCOPED_TRACE(points);
    const CampaignResult& result = go_on_with(cut_at_point(points, order), order);
    EXPECT_EQ(poses_of(result), poses);
    std::vector<JointVector> again;
    for (const TargetOutcome& target : result.as<TargetsResult>().targets) again.push_back(target.q);
    EXPECT_EQ(again, found);
  }
}

TEST(ReasonNotResumable, IsGivenForKindsThatCannotBeResumed) {
  EXPECT_THAT(std::string{reason_not_resumable("iso9283")}, HasSubstr("without a break"));
  EXPECT_THAT(std::string{reason_not_resumable("drift")}, HasSubstr("start it again"));
  EXPECT_EQ(reason_not_resumable("calibration"), "");
  EXPECT_EQ(reason_not_resumable("targets"), "");
}

}  // namespace
}  // namespace truepose::daemon
