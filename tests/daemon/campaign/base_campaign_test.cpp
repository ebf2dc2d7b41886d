// Campaigns that measure a work frame, in virtual time.
#include <gmock/gmock.h>

#include "config/frame_file.hpp"
#include "core/frames/work_frame.hpp"
#include "core/math/angles.hpp"
#include "daemon/campaign/campaign_options.hpp"
#include "daemon/cell/frame_order.hpp"
#include "tests/daemon/campaign_fixture.hpp"
#include "tests/daemon/jogging_hand.hpp"

namespace truepose::daemon {
namespace {

using testing::Contains;
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

TEST_F(BaseCampaignTest, ByTheTrackerIsStartedAgainAfterAnInterruption) {
  EXPECT_EQ(order_text(order, config, false), "");
}

/// The same fixture, whose points a tool touches that a tracker once measured.
struct TouchedBaseTest : BaseCampaignTest {
  TouchedBaseTest() {
    order.readings = 1;
    config::ToolFile tool{.number = 3, .arm = config.robot.model.name};
    tool.X_controller.translation() = kTcp_F_mm;
    tool.data = hand.tool_readings(10, truth.truth.X_WB, kTcp_F_mm);
    order.touch = TouchOrder{std::move(tool), {}};
    EXPECT_TRUE(use_model(order.by, model, order));
  }
  Eigen::Vector3d place_mm(std::size_t point) const { return X_BU * fixture_mm[point]; }
  /// Touches the requested point, a minute later, with an offset where one is given.
  void with_a_hand(std::vector<Eigen::Vector3d> offsets_mm = {}) {
    observer.at_pause = [this, offsets_mm] {
      ASSERT_LT(observer.pauses.size(), 30U) << observer.pauses.back();
      const auto touch = static_cast<std::size_t>(campaign->progress().done);
      const std::size_t point = touch / static_cast<std::size_t>(order.readings);
      const Eigen::Vector3d off_mm = touch < offsets_mm.size() ? offsets_mm[touch] : Eigen::Vector3d(0, 0, 0);
      jog(hand.touching(place_mm(point) + off_mm, kTcp_F_mm));
      later(std::chrono::seconds{60}, [this] { campaign->resume(); });
    };
  }
  void jog(const JointVector& q) { cell->start_motion(q, 100); }
  void later(Duration time, std::function<void()> act) {
    at(clock.now() - TimePoint{} + time, std::move(act));
  }
  const BaseResult& measured(std::shared_ptr<const CampaignPast> past = {}) {
    start(order, std::move(past));
    EXPECT_TRUE(go_on());
    EXPECT_TRUE(*outcome) << outcome->error().detail;
    return (***outcome).as<BaseResult>();
  }
  double off_mm(const Eigen::Isometry3d& X) const { return (X.translation() - X_BU.translation()).norm(); }

  const Eigen::Vector3d kTcp_F_mm{-30, 95, 210};
  const std::vector<Eigen::Vector3d> fixture_mm{{0, 0, 0}, {500, 0, 0}, {-60, 400, 0}, {450, 380, 120}};
  const ModelRecord model{.id = "m1", .created = "2026-11-25T00:47:22.237Z"};
  test::JoggingHand hand{truth.truth.robot, 0.02, 11};
};

TEST_F(TouchedBaseTest, AsksForATouchOfEachPointAndFindsTheFrameByTheJoints) {
  with_a_hand();
  const BaseResult& base = measured();
  EXPECT_THAT(observer.pauses,
              ElementsAre("touch point \"origin\" of base 5 with the TCP of tool 3, then resume the campaign",
                          HasSubstr("touch point \"x\""), HasSubstr("touch point \"xy\"")));
  ASSERT_THAT(journal.points, SizeIs(3));
  for (const StoredPoint& point : journal.points) {
    EXPECT_EQ(point.purpose, PointPurpose::Frame);
    EXPECT_FALSE(point.p_WS_mm) << "no tracker read it";
    EXPECT_EQ(point.q_commanded.size(), 0) << "nobody sent it there";
  }
  EXPECT_EQ(journal.points.back().q_actual, cell->q());
  EXPECT_LT(off_mm(base.frame.X), 4 * base.frame.sigma_mm());
  EXPECT_LT(Eigen::AngleAxisd(base.frame.X.linear().transpose() * X_BU.linear()).angle(),
            4 * base.frame.sigma_rad());
  EXPECT_EQ(campaign->progress().left(), 0);

  MeasuringCell nominal = order.by;
  nominal.cell.robot = config.robot.model;
  const auto by_nominal = work_frame(base.data, nominal, {order.touch->measured.X.translation(), nullptr});
  EXPECT_GT(off_mm(by_nominal->X), 20 * off_mm(base.frame.X)) << "what the controller's own arm makes of it";
}

TEST_F(TouchedBaseTest, CountsWhatIsNotKnownOfTheToolAsMuchAsTheReadings) {
  with_a_hand();
  const BaseResult base = measured();
  MeasuredFrame exact = order.touch->measured;
  exact.by_readings.setZero();
  const auto by_exact = work_frame(base.data, order.by, {exact.X.translation(), &exact});
  EXPECT_GT(base.frame.sigma_mm(), 1.02 * by_exact->sigma_mm());
  // A tool errs as the model does by which it was measured: some of that is no error of what it touches.
  const auto by_stated = work_frame(base.data, order.by, {exact.X.translation(), nullptr});
  EXPECT_LT(base.frame.sigma_mm(), by_stated->sigma_mm());
}

TEST_F(TouchedBaseTest, AsksForEachTouchOfAPointAndNamesTheOneThatTheOthersContradict) {
  order.readings = 3;
  with_a_hand({{0, 0, 0}, {0, 0, 0}, {0, 0, 0}, {0, 0, 0}, {0, 2, 0}});
  const BaseResult& base = measured();
  ASSERT_THAT(observer.pauses, SizeIs(9));
  EXPECT_THAT(observer.pauses[0], HasSubstr("with the TCP of tool 3 (1 of 3), then resume"));
  EXPECT_THAT(observer.pauses[4],
              HasSubstr("point \"x\" of base 5 with the TCP of tool 3 (2 of 3, turned to another side)"));
  EXPECT_THAT(base.frame.doubtful, Contains(4U));
  EXPECT_FALSE(base.frame.is_sound());
}

TEST_F(TouchedBaseTest, ShowsWhichPointIsFarFromItsKnownCoordinates) {
  order.points.push_back({{"corner", std::nullopt}});
  for (std::size_t i = 0; i < order.points.size(); ++i) order.points[i].point.p_mm = fixture_mm[i];
  with_a_hand({{0, 0, 0}, {0, 0, 2}});
  const BaseResult& base = measured();
  ASSERT_THAT(base.frame.misfit_mm, SizeIs(4));
  for (const double mm : base.frame.misfit_mm) EXPECT_GT(mm, 0.1) << "2 mm of one are shared by all";
  with_a_hand();
  for (const double mm : measured().frame.misfit_mm) EXPECT_LT(mm, 0.1);
}

TEST_F(TouchedBaseTest, AsksAgainWhileTheArmMoves) {
  observer.at_pause = [this] {
    jog(hand.touching(place_mm(0), kTcp_F_mm));
    later(std::chrono::milliseconds{300}, [this] {
      if (observer.pauses.size() < 2) return campaign->resume();
      campaign->abort("that is enough");
    });
  };
  start(order);
  ASSERT_TRUE(go_on());
  EXPECT_THAT(observer.pauses, ElementsAre(HasSubstr("touch point \"origin\""),
                                           HasSubstr("robot: the arm moves: touch point \"origin\"")));
  EXPECT_THAT(journal.points, IsEmpty());
}

TEST_F(TouchedBaseTest, AsksAgainWhereNobodyHasMovedTheArmSinceTheTouchBefore) {
  observer.at_pause = [this] {
    if (observer.pauses.size() == 1) jog(hand.touching(place_mm(0), kTcp_F_mm));
    if (observer.pauses.size() == 3) return campaign->abort("that is enough");
    later(std::chrono::seconds{60}, [this] { campaign->resume(); });
  };
  start(order);
  ASSERT_TRUE(go_on());
  EXPECT_THAT(observer.pauses.back(),
              HasSubstr("the arm has not been moved since it touched point \"origin\": touch point \"x\""));
  EXPECT_THAT(journal.points, SizeIs(1));
}

TEST_F(TouchedBaseTest, GoesOnWithTheNextTouchAfterAnInterruption) {
  order.readings = 2;
  for (const int touches : {1, 2, 3, 5}) {
    SCOPED_TRACE(touches);
    with_a_hand();
    std::shared_ptr<const CampaignPast> past;
    observer.at_point = [&, n = 0](const StoredPoint&) mutable {
      if (++n != touches) return;
      past = journal.past();
      campaign->interrupt("the daemon ends");
    };
    start(order);
    ASSERT_TRUE(go_on());
    ASSERT_FALSE(*outcome);
    EXPECT_TRUE(outcome->error().interrupted);
    observer.at_point = {};
    observer.pauses.clear();
    const BaseResult& base = measured(past);
    EXPECT_THAT(observer.pauses, SizeIs(static_cast<std::size_t>(6 - touches)));
    EXPECT_THAT(base.data.readings, SizeIs(6));
    EXPECT_EQ(base.data.readings.front().q, past->points.front().q_actual);
    EXPECT_LT(off_mm(base.frame.X), 4 * base.frame.sigma_mm());
    EXPECT_EQ(campaign->progress().done, 6);
    EXPECT_THAT(journal.resumptions.at(0).found, HasSubstr("the points that had been touched are kept"));
  }
}

TEST_F(TouchedBaseTest, RefusesTouchesThatAreNotOfItsOrder) {
  with_a_hand();
  std::shared_ptr<const CampaignPast> past;
  observer.at_point = [&](const StoredPoint&) {
    past = journal.past();
    campaign->interrupt("the daemon ends");
  };
  start(order);
  ASSERT_TRUE(go_on());
  observer.at_point = {};
  order.points.front().point.name = "another";
  start(order, past);
  ASSERT_TRUE(go_on());
  ASSERT_FALSE(*outcome);
  EXPECT_THAT(outcome->error().detail, HasSubstr("touch 1 was not of point \"another\""));
  EXPECT_TRUE(outcome->error().interrupted);
}

TEST_F(TouchedBaseTest, KeepsItsOrderInTheStore) {
  order.readings = 4;
  order.points[1].point.p_mm = Eigen::Vector3d(1, 2, 3);
  const auto kept = kept_order(order_text(order, config, false));
  ASSERT_TRUE(kept) << kept.error();
  EXPECT_EQ(kept->model_id, "m1");
  ASSERT_TRUE(kept->base);
  EXPECT_EQ(kept->base->number, 5);
  EXPECT_EQ(kept->base->readings, 4);
  ASSERT_THAT(kept->base->points, SizeIs(3));
  EXPECT_EQ(kept->base->points[1].point.name, kOnX);
  EXPECT_EQ(kept->base->points[1].point.p_mm, order.points[1].point.p_mm);
  const config::ToolFile tool = config::parse_tool(kept->touching_tool, "its tool", config.robot.model);
  EXPECT_EQ(tool.number, 3);
  EXPECT_EQ(tool.data.readings[9].q, order.touch->tool.data.readings[9].q);
  EXPECT_EQ(tool.data.readings[9].p_WS_mm, order.touch->tool.data.readings[9].p_WS_mm);
}

TEST_F(TouchedBaseTest, RefusesAToolThatIsOfNoUseUnderTheModel) {
  *order.touch->tool.data.readings[2].p_WS_mm += Eigen::Vector3d(0, 3, 0);
  EXPECT_EQ(use_model(order.by, model, order).error(),
            "tool 3: its readings contradict each other under this model; measure the tool again");
}

}  // namespace
}  // namespace truepose::daemon
