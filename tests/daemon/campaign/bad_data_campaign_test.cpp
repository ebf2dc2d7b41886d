// Campaigns whose data contradict themselves: none may correct an arm before somebody has looked at it.
#include <gmock/gmock.h>

#include "tests/daemon/campaign_fixture.hpp"

namespace truepose::daemon {
namespace {

using testing::Contains;
using testing::HasSubstr;
using testing::IsEmpty;

auto contain(const char* sentence) {
  return Contains(testing::Field(&Finding::sentence, HasSubstr(sentence)));
}

struct BadDataTest : CampaignTest {
  BadDataTest() {
    config.campaign.identify_poses = 19;
    config.campaign.reference_every = config::CampaignConfig{}.reference_every;
  }
  /// Runs it, the tracker moved by so much after so many points of a purpose.
  const CampaignResult& bumped(double by_mm, PointPurpose purpose, int after) {
    observer.at_point = [=, this, n = 0](const StoredPoint& point) mutable {
      if (point.purpose == purpose && ++n == after) cell->bump_tracker(by_mm * Eigen::Vector3d(0.6, 0, 0.8));
    };
    start();
    EXPECT_TRUE(go_on() && *outcome);
    return ***outcome;
  }
};

TEST_F(BadDataTest, ASoundCampaignIsNotInDoubt) {
  const CampaignResult& result = bumped(0, PointPurpose::Identify, 9);
  EXPECT_LT(result.as<CalibrationResult>().calibration.validate->after.mean, 0.06);
  EXPECT_FALSE(result.as<CalibrationResult>().verdict.failed());
}

TEST_F(BadDataTest, ATrackerThatIsBumpedWhileItIdentifiesLeavesTheModelInDoubt) {
  const CampaignResult& result = bumped(5, PointPurpose::Identify, 9);
  EXPECT_GT(result.as<CalibrationResult>().calibration.validate->after.mean, 0.5);
  EXPECT_THAT(result.as<CalibrationResult>().verdict.findings,
              contain("the reference pose did not stay where it was"));
  EXPECT_FALSE(result.as<CalibrationResult>().remeasured) << "the arm is not led by it";
  EXPECT_THAT(observer.troubles, Contains(HasSubstr("the model is in doubt")));
}

TEST_F(BadDataTest, ATrackerThatIsBumpedBeforeValidationLeavesTheModelInDoubt) {
  for (const int reference_every : {config.campaign.reference_every, 0}) {
    config.campaign.reference_every = reference_every;
    const CampaignResult& result = bumped(2, PointPurpose::Identify, 19);
    EXPECT_GT(result.as<CalibrationResult>().calibration.validate->after.mean, 1);
    EXPECT_THAT(result.as<CalibrationResult>().verdict.findings, contain("the validation points are off by"))
        << reference_every;
  }
}

TEST_F(BadDataTest, PointsThatTheTrackerItselfCallsNoisyAreMeasuredAgainAndNeverStored) {
  truth.faults.scattering = 1.0 / 6;
  start();
  ASSERT_TRUE(go_on());
  ASSERT_TRUE(*outcome) << outcome->error().detail;
  for (const StoredPoint& point : journal.points) EXPECT_LT(point.std_mm.maxCoeff(), 0.1);
  EXPECT_THAT(observer.troubles, Contains(HasSubstr("the readings of this point scatter by 3.000 mm")));
  EXPECT_FALSE((***outcome).as<CalibrationResult>().verdict.failed());
  EXPECT_LT((***outcome).as<CalibrationResult>().calibration.validate->after.mean, 0.06);
}

TEST_F(BadDataTest, NothingIsIdentifiedWhereEveryPointIsNoisyByTheTrackersOwnAccount) {
  truth.faults.scattering = 1;
  config.campaign.pause_after_lost = 0;
  start();
  ASSERT_TRUE(go_on());
  EXPECT_FALSE(*outcome);
  EXPECT_THAT(journal.points, IsEmpty());
  ASSERT_FALSE(journal.skipped.empty());
  EXPECT_THAT(journal.skipped[0].reason, HasSubstr("the readings of this point scatter by 3.000 mm"));
}

}  // namespace
}  // namespace truepose::daemon
