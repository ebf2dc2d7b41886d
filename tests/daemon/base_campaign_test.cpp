// Campaigns that measure a work frame, in virtual time.
#include <gmock/gmock.h>

#include "core/math/angles.hpp"
#include "tests/daemon/campaign_fixture.hpp"

namespace truepose::daemon {
namespace {

using testing::Contains;
using testing::Each;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;

/// A fixture with a reflector at each of its points.
struct BaseCampaignTest : CampaignTest {
  BaseCampaignTest() {
    const CalibratedCell known{truth.truth.robot,
                               BasePose::of(truth.truth.X_WB),
                               {Reflector{config.reflector.name, truth.truth.p_FS_mm}}};
    const int size = ParameterLayout::of(known).size();
    order.number = 5;
    order.by = {known,
                Eigen::VectorXd::Constant(size, 1e-10).asDiagonal(),
                {{.range_mm = 0.01, .transverse_mm = 0.01}, truth.truth.repeatability_mm}};
    add(kOrigin, {0, 0, 0});
    add(kOnX, {500, 0, 0});
    add(kInXy, {-60, 400, 0});
  }
  void add(const char* name, const Eigen::Vector3d& p_U_mm) {
    const Eigen::Vector3d p_B_mm = X_BU * p_U_mm;
    truth.instrument.nests_mm.push_back(truth.truth.X_WB * p_B_mm);
    order.points.push_back({{name, std::nullopt}, p_B_mm + Eigen::Vector3d(30, -20, 10)});
  }
  /// Resumes a minute after each pause.
  void with_a_hand() {
    observer.at_pause = [this] {
      at(clock.now() - TimePoint{} + std::chrono::seconds{60}, [this] { campaign->resume(); });
    };
  }

  const Eigen::Isometry3d X_BU = pose_from_kuka({1400, -300, 500}, {30, 2, -1});
  BaseOrder order;
};

TEST_F(BaseCampaignTest, AsksForTheReflectorAtEachPointAndFindsTheFrameWhileTheArmStandsStill) {
  with_a_hand();
  start(order);
  ASSERT_TRUE(go_on());
  ASSERT_TRUE(*outcome) << outcome->error().detail;
  const BaseResult& base = (***outcome).as<BaseResult>();
  EXPECT_THAT(observer.pauses, ElementsAre(HasSubstr("put the reflector at point \"origin\" of base 5"),
                                           HasSubstr("\"x\""), HasSubstr("\"xy\"")));
  ASSERT_THAT(journal.points, SizeIs(9));
  for (const StoredPoint& point : journal.points) {
    EXPECT_EQ(point.purpose, PointPurpose::Frame);
    EXPECT_EQ(point.q_actual, truth.q_start);
  }
  EXPECT_EQ(cell->q(), truth.q_start);
  EXPECT_LT((base.frame.X.translation() - X_BU.translation()).norm(), 4 * base.frame.sigma_mm());
  EXPECT_LT(Eigen::AngleAxisd(base.frame.X.linear().transpose() * X_BU.linear()).angle(),
            4 * base.frame.sigma_rad());
  EXPECT_THAT(base.frame.doubtful, IsEmpty());
  EXPECT_EQ(campaign->progress().left(), 0);
}

TEST_F(BaseCampaignTest, AsksAgainWhereTheTrackerDoesNotSeeThePoint) {
  order.points[1].p_B_mm += Eigen::Vector3d(0, 0, 900);
  config.campaign.retries = 0;
  observer.at_pause = [this] {
    if (observer.pauses.size() == 3) return campaign->abort("that is enough");
    at(clock.now() - TimePoint{} + std::chrono::seconds{60}, [this] { campaign->resume(); });
  };
  start(order);
  ASSERT_TRUE(go_on());
  EXPECT_THAT(observer.pauses,
              ElementsAre(HasSubstr("\"origin\""), HasSubstr("\"x\""),
                          HasSubstr("the tracker did not see it: put the reflector at point \"x\"")));
}

}  // namespace
}  // namespace truepose::daemon
