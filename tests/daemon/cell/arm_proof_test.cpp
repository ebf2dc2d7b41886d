#include <gmock/gmock.h>

#include "config/cell_setup.hpp"
#include "core/math/angles.hpp"
#include "core/plan/scene.hpp"
#include "tests/daemon/campaign_fixture.hpp"

namespace truepose::daemon {
namespace {

using testing::AllOf;
using testing::HasSubstr;

/// A robot file with one mistake.
struct Mistake {
  int joint;  ///< from 1
  bool sign;  ///< it turns the other way; else its zero is 90 deg off
};

void PrintTo(const Mistake& mistake, std::ostream* out) {
  *out << (mistake.sign ? "sign of joint " : "zero of joint ") << mistake.joint;
}

struct ARobotFileWithAMistake : CampaignTest, testing::WithParamInterface<Mistake> {
  ARobotFileWithAMistake() {
    Joint& joint = config.robot.model.joints[static_cast<std::size_t>(GetParam().joint - 1)];
    GetParam().sign ? joint.sign *= -1 : joint.theta_rad += 90 * kRadPerDeg;
  }
};

TEST_P(ARobotFileWithAMistake, IsRefusedWithinTheFirstSmallMotionsAndTheJointIsNamed) {
  start();
  ASSERT_TRUE(go_on());
  ASSERT_FALSE(*outcome);
  EXPECT_EQ(outcome->error().fault, CampaignFault::WrongArm);
  const std::string name = "joint " + std::to_string(GetParam().joint);
  EXPECT_THAT(outcome->error().detail,
              HasSubstr(name + (GetParam().sign ? " turns the other way" : " has its zero -90.00 deg off")));
  for (int other = 1; other <= 6; ++other) {
    if (other == GetParam().joint) continue;
    EXPECT_THAT(outcome->error().detail, testing::Not(HasSubstr("joint " + std::to_string(other))));
  }
  EXPECT_LT((cell->q() - truth.q_start).cwiseAbs().maxCoeff(), 1.001 * kRadPerDeg);
  EXPECT_EQ(journal.points.size(), 0U);
}

std::vector<Mistake> all_mistakes() {
  std::vector<Mistake> mistakes;
  for (int joint = 1; joint <= 6; ++joint) {
    mistakes.push_back({joint, true});
    mistakes.push_back({joint, false});
  }
  return mistakes;
}

INSTANTIATE_TEST_SUITE_P(OfEveryJoint, ARobotFileWithAMistake, testing::ValuesIn(all_mistakes()));

TEST_F(CampaignTest, TheRightArmMovesEveryJointABitBeforeItsFirstRealMotion) {
  start();
  JointVector least = truth.q_start, most = truth.q_start;
  observer.at_phase = [&](CampaignPhase phase) {
    if (phase == CampaignPhase::Plan) {
      EXPECT_EQ(cell->q(), truth.q_start) << "back where it was";
    }
  };
  boost::asio::co_spawn(
      io,
      [&]() -> boost::asio::awaitable<void> {
        while (observer.phases.back() == CampaignPhase::Connect) {
          least = least.cwiseMin(cell->q());
          most = most.cwiseMax(cell->q());
          const TimePoint next = clock.now() + std::chrono::milliseconds{20};
          co_await clock.sleep_until(next);
        }
      },
      [](std::exception_ptr failed) { EXPECT_FALSE(failed); });
  ASSERT_TRUE(go_on());
  ASSERT_TRUE(*outcome) << outcome->error().detail;
  const JointVector way = most - least;
  EXPECT_NEAR(way.minCoeff(), kRadPerDeg, 1e-6);
  EXPECT_NEAR(way.maxCoeff(), kRadPerDeg, 1e-6);
}

/// A post with so much room between it and the arm's flange at q: on the one or the other side of the arm, as
/// axis 1 turns.
Capsule post_near(const RobotModel& robot, const JointVector& q, double room_mm, double side) {
  constexpr double kRadius_mm = 10;
  const Eigen::Vector3d flange_mm = forward_kinematics(robot, q).translation();
  const Eigen::Vector3d aside = side * Eigen::Vector3d::UnitZ().cross(flange_mm).normalized();
  const Eigen::Vector3d foot_mm = flange_mm + (kRadius_mm + room_mm) * aside;
  return {{foot_mm.x(), foot_mm.y(), 0}, {foot_mm.x(), foot_mm.y(), 3000}, kRadius_mm};
}

/// On the one or the other side.
struct AnArmNearAPost : CampaignTest, testing::WithParamInterface<double> {};

TEST_P(AnArmNearAPost, MakesItsFirstSmallMotionAwayFromThat) {
  config.surroundings.obstacles = {post_near(config.robot.model, truth.q_start, 30, GetParam())};
  PoseChecker near{config::scene_of(config)};
  ASSERT_TRUE(near.collision_at(truth.q_start));
  start();
  const auto has_turned = [this] { return std::abs(cell->q()[0] - truth.q_start[0]) > 0.5 * kRadPerDeg; };
  ASSERT_TRUE(clock.run(io, has_turned));
  EXPECT_GT(near.spare_mm(cell->q()), near.spare_mm(truth.q_start));
  ASSERT_TRUE(go_on());
  EXPECT_TRUE(*outcome) << outcome->error().detail;
}

INSTANTIATE_TEST_SUITE_P(OnEachSide, AnArmNearAPost, testing::Values(1.0, -1.0));

TEST_F(CampaignTest, AnArmWhoseControllerChangesItsMindStopsTheCampaignAtThatPose) {
  start();
  observer.at_point = [this](const StoredPoint& point) {
    if (point.pose == 5) robot->report_joint_turned(3, 2 * kRadPerDeg);
  };
  ASSERT_TRUE(go_on());
  ASSERT_FALSE(*outcome);
  EXPECT_EQ(outcome->error().fault, CampaignFault::WrongArm);
  EXPECT_THAT(outcome->error().detail,
              AllOf(HasSubstr("mm apart"), HasSubstr("joint 4 has its zero -2.00 deg off")));
  EXPECT_EQ(journal.points.size(), 5U);
}

}  // namespace
}  // namespace truepose::daemon
