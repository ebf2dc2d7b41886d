// Campaigns that measure a tool, in virtual time.
#include <gmock/gmock.h>

#include <algorithm>
#include <array>

#include "core/arm/forward.hpp"
#include "core/math/angles.hpp"
#include "daemon/campaign/campaign_options.hpp"
#include "daemon/campaign/tool_cell.hpp"
#include "tests/daemon/campaign_fixture.hpp"

namespace truepose::daemon {
namespace {

using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::SizeIs;

/// A tool of which the test knows where it truly is, and a model that knows the arm.
struct ToolCampaignTest : CampaignTest {
  ToolCampaignTest() {
    const CalibratedCell known{truth.truth.robot,
                               BasePose::of(truth.truth.X_WB),
                               {Reflector{config.reflector.name, truth.truth.p_FS_mm}}};
    const int size = ParameterLayout::of(known).size();
    order.number = 3;
    order.model_id = "m1";
    order.by = {known,
                Eigen::VectorXd::Constant(size, 1e-10).asDiagonal(),
                {{.range_mm = 0.01, .transverse_mm = 0.01}, truth.truth.repeatability_mm}};
    order.points = {{{kOrigin, std::nullopt}, {80, 40, 60}}};
    put_reflector_at({0, 0, 0});
  }

  /// Where the tracker finds it, of the point that has these coordinates in the tool.
  void put_reflector_at(const Eigen::Vector3d& p_T_mm) { truth.truth.p_FS_mm = X_FT * p_T_mm; }

  void start_tool(std::shared_ptr<const CampaignPast> past = {}) {
    config = cell_with_tool(cell_file, order);
    start(order, std::move(past));
  }
  const ToolResult& measured() {
    start_tool();
    EXPECT_TRUE(go_on());
    EXPECT_TRUE(*outcome) << outcome->error().detail;
    return (***outcome).as<ToolResult>();
  }
  std::string refused() {
    start_tool();
    EXPECT_TRUE(go_on());
    EXPECT_FALSE(*outcome);
    return *outcome ? "" : outcome->error().detail;
  }
  /// Does at each pause what its sentence asks for, and resumes.
  void with_a_hand(std::vector<Eigen::Vector3d> places_T_mm) {
    observer.at_pause = [this, places_T_mm, n = std::size_t{0}]() mutable {
      ASSERT_LT(n, places_T_mm.size());
      cell->put_reflector(X_FT * places_T_mm[n++]);
      at(clock.now() - TimePoint{} + std::chrono::seconds{60}, [this] { campaign->resume(); });
    };
  }

  config::CellConfig cell_file = config;
  const Eigen::Isometry3d X_FT = pose_from_kuka({-30, 95, 210}, {20, -35, 70});
  ToolOrder order;
};

TEST_F(ToolCampaignTest, FindsTheTcpInTenPosesAlthoughNobodyKnowsWhereItIs) {
  const ToolResult& tool = measured();
  EXPECT_THAT(journal.points, SizeIs(10));
  for (const StoredPoint& point : journal.points) {
    EXPECT_EQ(point.purpose, PointPurpose::Frame);
    EXPECT_EQ(point.smr, kOrigin);
  }
  EXPECT_LT((tool.frame.X.translation() - X_FT.translation()).norm(), 4 * tool.frame.sigma_mm());
  EXPECT_LT(tool.frame.sigma_mm(), 0.03);
  EXPECT_FALSE(tool.frame.is_orientation_known);
  EXPECT_TRUE(tool.frame.is_sound());
  EXPECT_LT(tool.frame.shift.value().unseen_mm(), 0.5);
  EXPECT_EQ(campaign->progress().left(), 0);
  EXPECT_LT(*observer.last.error_mm, 0.2) << "the first reading already tells where to look";
}

TEST_F(ToolCampaignTest, FindsAllOfItInOnePoseOfA6DTarget) {
  truth.orientation_sigma_rad = 5e-5;
  truth.truth.R_FT = X_FT.linear();
  order.poses = 1;
  const ToolResult& tool = measured();
  EXPECT_THAT(journal.points, SizeIs(1));
  EXPECT_TRUE(tool.frame.is_orientation_known);
  EXPECT_LT((tool.frame.X.translation() - X_FT.translation()).norm(), 4 * tool.frame.sigma_mm());
  EXPECT_LT(angle_between(tool.frame.X.linear(), X_FT.linear()), 4 * tool.frame.sigma_rad());
  EXPECT_LT(tool.frame.sigma_rad(), 2e-4);
}

TEST_F(ToolCampaignTest, TakesA6DTargetThatIsPutFromPointToPointForAReflector) {
  truth.orientation_sigma_rad = 5e-5;
  order.points = {{{kOrigin, std::nullopt}, {80, 40, 60}},
                  {{kOnX, std::nullopt}, {80, 40, 60}},
                  {{kInXy, std::nullopt}, {80, 40, 60}}};
  with_a_hand({{120, 0, 0}, {-20, 90, 0}});
  const ToolResult& tool = measured();
  EXPECT_LT(angle_between(tool.frame.X.linear(), X_FT.linear()), 4 * tool.frame.sigma_rad())
      << "by the points, not by how the target is mounted";
}

TEST_F(ToolCampaignTest, TurnsTheFlangeAsDifferentlyAsTheTrackerSeesIt) {
  measured();
  double least_rad = 10;
  for (const StoredPoint& a : journal.points)
    for (const StoredPoint& b : journal.points) {
      if (a.pose == b.pose) continue;
      const Eigen::Matrix3d turn = forward_kinematics(config.robot.model, a.q_target).linear().transpose() *
                                   forward_kinematics(config.robot.model, b.q_target).linear();
      least_rad = std::min(least_rad, Eigen::AngleAxisd(turn).angle());
    }
  EXPECT_GT(least_rad, 30 * kRadPerDeg);
}

TEST_F(ToolCampaignTest, MayHaveItsTcpOnTheLastAxis) {
  order.points.front().p_F_mm = {0, 0, 250};
  truth.truth.p_FS_mm = {0.5, -0.4, 250.3};
  EXPECT_LT((measured().frame.X.translation() - truth.truth.p_FS_mm).norm(), 0.1);
}

TEST_F(ToolCampaignTest, PausesForTheHandThatPutsTheReflectorFromPointToPoint) {
  order.points = {{{kOrigin, std::nullopt}, {80, 40, 60}},
                  {{kOnX, std::nullopt}, {80, 40, 60}},
                  {{kInXy, std::nullopt}, {80, 40, 60}}};
  with_a_hand({{120, 0, 0}, {-20, 90, 0}});
  const ToolResult& tool = measured();
  EXPECT_THAT(observer.pauses,
              ElementsAre(HasSubstr("put the reflector at point \"x\" of tool 3"), HasSubstr("\"xy\"")));
  EXPECT_THAT(journal.points, SizeIs(30));
  EXPECT_TRUE(tool.frame.is_orientation_known);
  EXPECT_LT((tool.frame.X.translation() - X_FT.translation()).norm(), 4 * tool.frame.sigma_mm());
  EXPECT_LT(Eigen::AngleAxisd(tool.frame.X.linear().transpose() * X_FT.linear()).angle(),
            4 * tool.frame.sigma_rad());
}

TEST_F(ToolCampaignTest, MeasuresReflectorsAtAllPointsTogether) {
  const Eigen::Vector3d x_T_mm(120, 0, 0), xy_T_mm(-20, 90, 0);
  const Eigen::Vector3d rough_mm(8, -6, 5);
  order.together = true;
  order.points = {{{kOrigin, std::nullopt}, X_FT.translation() + rough_mm},
                  {{kOnX, std::nullopt}, X_FT * x_T_mm + rough_mm},
                  {{kInXy, std::nullopt}, X_FT * xy_T_mm + rough_mm}};
  for (const Eigen::Vector3d& p_T_mm : {x_T_mm, xy_T_mm})
    truth.truth.further.push_back({X_FT * p_T_mm, truth.truth.facing_F, truth.truth.acceptance_rad});
  const ToolResult& tool = measured();
  EXPECT_EQ(campaign->progress().total, 10);
  EXPECT_GE(journal.points.size(), 27U) << "of each pose all that the tracker sees";
  EXPECT_LT((tool.frame.X.translation() - X_FT.translation()).norm(), 4 * tool.frame.sigma_mm());
}

TEST_F(ToolCampaignTest, SaysThatTheReflectorSeemsToBeWhereItWasCalibratedWith) {
  truth.truth.p_FS_mm = order.by.cell.reflectors.front().p_FS_mm;
  measured();
  EXPECT_THAT(observer.troubles, Contains(HasSubstr("see that it sits at the tool")));
}

TEST_F(ToolCampaignTest, NamesAReadingThatTheOthersContradict) {
  observer.at_point = [this, n = 0](const StoredPoint&) mutable {
    if (++n == 4) cell->put_reflector(truth.truth.p_FS_mm + Eigen::Vector3d(2, 0, 0));
    if (n == 5) cell->put_reflector(truth.truth.p_FS_mm);
  };
  EXPECT_THAT(measured().frame.doubtful, ElementsAre(4U));
}

TEST_F(ToolCampaignTest, RefusesOrientationsThatAreAllAlike) {
  constexpr std::array<double, 6> kMiddle_deg{0, -90, 90, 0, 8, 0};
  for (std::size_t i = 0; i < kMiddle_deg.size(); ++i) {
    Joint& joint = cell_file.robot.model.joints[i];
    joint.min = (kMiddle_deg[i] - 3) * kRadPerDeg;
    joint.max = (kMiddle_deg[i] + 3) * kRadPerDeg;
  }
  cell_file.campaign.candidates = 30;
  cell_file.campaign.limit_margin_deg = 0;
  EXPECT_THAT(refused(), HasSubstr("tilt the flange's direction"));
}

TEST_F(ToolCampaignTest, TellsNoTcpByFewerOrientationsThanShowASlip) {
  order.poses = 3;
  EXPECT_THAT(refused(), HasSubstr("tool 3: 3 of at least 4 poses are enough for a 6-D target alone"));
  EXPECT_THAT(journal.points, SizeIs(1)) << "the first reading shows that it has no orientation";
}

TEST_F(ToolCampaignTest, KeepsClearOfItWhatIsKnownOfTheTool) {
  cell_file.robot.body = {{7, {{0, 0, 0}, {0, 0, 40}, 50}}};
  EXPECT_EQ(cell_with_tool(cell_file, order).robot.body.size(), 1U) << "nothing is known of it";
  order.reach_F_mm = Eigen::Vector3d(0, 0, 500);
  const std::vector<BodyPart> body = cell_with_tool(cell_file, order).robot.body;
  ASSERT_THAT(body, SizeIs(2));
  EXPECT_EQ(body[1].link, 7);
  EXPECT_GT(body[1].capsule.to_mm.z(), 400);
  EXPECT_LT(body[1].capsule.to_mm.z() + body[1].capsule.radius_mm, 500) << "the reflector is outside of it";
}

TEST_F(ToolCampaignTest, KeepsItsOrderInTheStore) {
  order.points = {{{"a", Eigen::Vector3d(1, 2, 3)}, {4, 5, 6}}, {{"b", Eigen::Vector3d(0, 0, 9)}, {7, 8, 9}}};
  order.together = true;
  order.facing_F = Eigen::Vector3d(0, 1, 0);
  order.poses = 7;
  order.reach_F_mm = Eigen::Vector3d(0, 0, 500);
  const auto kept = kept_order(order_text(order, config, false));
  ASSERT_TRUE(kept) << kept.error();
  EXPECT_EQ(kept->model_id, "m1");
  ASSERT_TRUE(kept->tool);
  EXPECT_EQ(kept->tool->number, 3);
  EXPECT_EQ(kept->tool->poses, 7);
  EXPECT_TRUE(kept->tool->together);
  EXPECT_EQ(kept->tool->facing_F, order.facing_F);
  EXPECT_EQ(kept->tool->reach_F_mm, order.reach_F_mm);
  ASSERT_THAT(kept->tool->points, SizeIs(2));
  EXPECT_EQ(kept->tool->points[1].point.name, "b");
  EXPECT_EQ(kept->tool->points[1].point.p_mm, order.points[1].point.p_mm);
  EXPECT_EQ(kept->tool->points[1].p_F_mm, order.points[1].p_F_mm);
}

TEST_F(ToolCampaignTest, ComesToTheSameAtWhateverPointItWasInterrupted) {
  truth.noise = {};
  truth.truth.repeatability_mm = 0;
  order.points = {{{kOrigin, std::nullopt}, {80, 40, 60}},
                  {{kOnX, std::nullopt}, {80, 40, 60}},
                  {{kInXy, std::nullopt}, {80, 40, 60}}};
  const std::vector<Eigen::Vector3d> places_T_mm{{0, 0, 0}, {120, 0, 0}, {-20, 90, 0}};
  for (const int points : {1, 6, 10, 14, 20, 29}) {
    SCOPED_TRACE(points);
    put_reflector_at(places_T_mm[0]);
    with_a_hand({places_T_mm[1], places_T_mm[2]});
    std::shared_ptr<const CampaignPast> past;
    observer.at_point = [&, n = 0](const StoredPoint&) mutable {
      if (++n != points) return;
      past = journal.past();
      campaign->abort("cut off");
    };
    start_tool();
    ASSERT_TRUE(go_on());
    ASSERT_TRUE(past);
    observer.at_point = {};
    // The reflector is where it was; before a point that was not begun yet the campaign asks for it.
    const auto point = static_cast<std::size_t>(points) / 10;
    put_reflector_at(places_T_mm[points % 10 == 0 ? point - 1 : point]);
    with_a_hand(
        {places_T_mm.begin() + (points % 10 == 0 ? points / 10 : points / 10 + 1), places_T_mm.end()});
    start_tool(past);
    ASSERT_TRUE(go_on());
    ASSERT_TRUE(*outcome) << outcome->error().detail;
    const ToolResult& tool = (***outcome).as<ToolResult>();
    EXPECT_THAT(tool.data.readings, SizeIs(30));
    EXPECT_LT((tool.frame.X.translation() - X_FT.translation()).norm(), 1e-6);
    EXPECT_EQ(campaign->progress().done, 30);
  }
}

}  // namespace
}  // namespace truepose::daemon
