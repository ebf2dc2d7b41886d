#include <gmock/gmock.h>

#include <algorithm>
#include <boost/asio/co_spawn.hpp>
#include <boost/asio/post.hpp>
#include <optional>

#include "core/math/angles.hpp"
#include "tests/daemon/campaign_fixture.hpp"
#include "tests/trials.hpp"

namespace truepose::daemon {
namespace {

namespace asio = boost::asio;
using namespace std::chrono_literals;
using testing::AllOf;
using testing::Each;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Ne;
using testing::SizeIs;

using HaltedCampaignTest = CampaignTest;

TEST_F(HaltedCampaignTest, BeginsThoughItsDevicesAreAwayForAMomentAsItConnects) {
  start();
  robot->leave(500ms);
  tracker->leave(1500ms);
  ASSERT_TRUE(go_on());
  ASSERT_TRUE(*outcome) << outcome->error().detail;
  EXPECT_THAT(observer.troubles, ElementsAre("robot: the controller does not answer; trying again",
                                             "tracker: the tracker does not answer; trying again"));
}

TEST_F(HaltedCampaignTest, EndsBeforeTheArmMovesWhereADeviceDoesNotAnswer) {
  start();
  tracker->leave(1h);
  ASSERT_TRUE(go_on());
  ASSERT_FALSE(*outcome);
  EXPECT_THAT(outcome->error().detail, HasSubstr("the tracker does not answer"));
  EXPECT_LT(clock.now(), TimePoint{} + 1min);
  EXPECT_FALSE(cell->moving());
}

TEST_F(HaltedCampaignTest, WaitsForADeviceAsLongAsItIsAwayAndSaysWhyOnce) {
  const Duration away = all_trials() ? 100h : 30h;
  start();
  observer.at_point = [this, away](const StoredPoint& point) {
    if (point.pose == 3) {
      robot->disconnect();
      robot->leave(away);
    }
  };
  ASSERT_TRUE(go_on());
  ASSERT_TRUE(*outcome) << outcome->error().detail;
  EXPECT_GT(clock.now(), TimePoint{} + away);
  EXPECT_EQ(journal.points.size(), 40U);
  EXPECT_THAT(journal.skipped, IsEmpty());
  EXPECT_EQ(std::ranges::count_if(observer.troubles,
                                  [](const std::string& trouble) {
                                    return trouble == "robot: the controller does not answer; trying again";
                                  }),
            1);
}

TEST_F(HaltedCampaignTest, StandsStillUntilItIsResumedWhereTheBeamIsLostAtTwoPosesInARow) {
  start();
  drivers::MockFaults somebody_in_the_beam;
  somebody_in_the_beam.beam_broken = 1;
  observer.at_point = [&](const StoredPoint& point) {
    if (point.pose == 5) cell->use_faults(somebody_in_the_beam);
  };
  EXPECT_FALSE(go_on());
  EXPECT_EQ(journal.points.size(), 5U);
  EXPECT_THAT(journal.skipped, SizeIs(1)) << "poses are not burnt one after the other";
  ASSERT_THAT(observer.pauses, SizeIs(1));
  EXPECT_THAT(observer.pauses[0], AllOf(HasSubstr("2 poses in a row could not be measured, pose 29 last"),
                                        HasSubstr("the beam was broken"), HasSubstr("the cell is empty"),
                                        HasSubstr("resume the campaign")));
  const JointVector stands = cell->q();

  cell->use_faults({});
  EXPECT_FALSE(go_on()) << "that the beam is back does not say that the cell is empty";
  EXPECT_EQ(cell->q(), stands);
  campaign->resume();
  ASSERT_TRUE(go_on());
  ASSERT_TRUE(*outcome) << outcome->error().detail;
  EXPECT_THAT(journal.skipped, SizeIs(1)) << "the pose at which it paused was tried again";
  EXPECT_EQ(campaign->progress().left(), 0);
}

TEST_F(HaltedCampaignTest, GivesUpOnePoseAtMostForEachTimeThatItIsResumedWithoutABeam) {
  truth.faults.no_target = 1;
  observer.at_pause = [this] { asio::post(io, [this] { campaign->resume(); }); };
  start();
  ASSERT_TRUE(go_on());
  ASSERT_FALSE(*outcome);
  ASSERT_EQ(journal.skipped.size(), 7U);
  EXPECT_EQ(journal.skipped[0].attempts, 3);
  EXPECT_EQ(journal.skipped[3].attempts, 6);
  EXPECT_THAT(journal.skipped[3].reason, HasSubstr("no reflector found"));
  EXPECT_THAT(observer.pauses, SizeIs(6));
}

TEST_F(HaltedCampaignTest, PausesForPosesThatAreLostInARowForWhateverReason) {
  config.campaign.pause_after_lost = 3;
  start();
  observer.at_point = [&](const StoredPoint& point) {
    if (point.pose == 5) cell->use_faults({.tracker_busy = 1});
  };
  observer.at_pause = [this] {
    cell->use_faults({});
    asio::post(io, [this] { campaign->resume(); });
  };
  ASSERT_TRUE(go_on());
  ASSERT_TRUE(*outcome) << outcome->error().detail;
  EXPECT_THAT(journal.skipped, SizeIs(2));
  ASSERT_THAT(observer.pauses, SizeIs(1));
  EXPECT_THAT(
      observer.pauses[0],
      AllOf(HasSubstr("3 poses in a row"),
            HasSubstr("the tracker is busy; close the other program that uses the tracker, then resume")));
}

TEST_F(HaltedCampaignTest, OnePoseThatHidesTheReflectorDoesNotStopTheCampaign) {
  start();
  drivers::MockFaults hidden;
  hidden.no_target = 1;
  observer.at_point = [&](const StoredPoint& point) {
    cell->use_faults(point.pose == 5 ? hidden : drivers::MockFaults{});
  };
  observer.at_trouble = [this](const std::string& sentence) {
    if (sentence.contains("attempt 3 of 3")) cell->use_faults({});
  };
  ASSERT_TRUE(go_on());
  ASSERT_TRUE(*outcome) << outcome->error().detail;
  ASSERT_THAT(journal.skipped, SizeIs(1));
  std::vector<int> measured;
  for (const Measurement& point : measurement_data((***outcome).points, "1").points)
    measured.push_back(point.pose);
  EXPECT_THAT(measured, Each(Ne(journal.skipped[0].pose))) << "a pose has one number everywhere";
  EXPECT_THAT(observer.pauses, IsEmpty());
}

TEST_F(HaltedCampaignTest, AnAbortSaysWhereTheArmCouldNotBeBraked) {
  start();
  at(60s, [this] {
    robot->disconnect();
    campaign->abort("asked for by an operator");
  });
  ASSERT_TRUE(go_on());
  EXPECT_EQ(outcome->error().fault, CampaignFault::Aborted);
  EXPECT_THAT(outcome->error().detail,
              AllOf(HasSubstr("asked for by an operator; the arm could not be braked and may still move"),
                    HasSubstr("robot: not connected")));
}

TEST_F(HaltedCampaignTest, CanBeAbortedWhilePausedAndBeforeItsFirstStep) {
  start();
  observer.at_point = [this](const StoredPoint&) { campaign->pause(); };
  EXPECT_FALSE(go_on());
  campaign->abort("enough");
  ASSERT_TRUE(go_on());
  EXPECT_EQ(outcome->error().fault, CampaignFault::Aborted);

  outcome.reset();
  start();
  campaign->abort("too early");
  ASSERT_TRUE(go_on());
  EXPECT_EQ(outcome->error().detail, "too early");
}

}  // namespace
}  // namespace truepose::daemon
