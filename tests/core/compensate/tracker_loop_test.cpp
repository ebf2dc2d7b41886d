#include "core/compensate/tracker_loop.hpp"

#include <gmock/gmock.h>

#include <cmath>
#include <functional>

#include "core/math/angles.hpp"
#include "core/math/random.hpp"
#include "tests/core/example_arms.hpp"

namespace truepose {
namespace {

using testing::Le;
using testing::Optional;
using testing::SizeIs;

/// The model of an arm, the arm as it really is, and a target where the model's reflector would be.
struct TrackerLoopTest : testing::Test {
  explicit TrackerLoopTest(const RobotModel& robot = example::kr210())
      : model{example::placed(robot, random)}, truth{model} {
    truth.robot = example::deviating(robot, random, 0.2, 2e-4);
    q = JointVector::Zero(robot.joint_count());
    q.tail(6) << 10, -80, 70, 20, 60, -30;
    q.tail(6) *= kRadPerDeg;
    wanted = model.predict(q, 0);
  }

  Eigen::Vector3d noise(double sigma_mm) {
    return sigma_mm * Eigen::Vector3d{random.normal(), random.normal(), random.normal()};
  }
  /// Feeds readings until the loop ends.
  void run(TrackerLoop& loop, const std::function<Eigen::Vector3d(const JointVector&)>& reading) {
    while (!loop.end()) loop.add(reading(loop.q()));
  }

  Random random{3};
  CalibratedCell model, truth;
  JointVector q;
  Eigen::Vector3d wanted;
};

TEST_F(TrackerLoopTest, BringsTheReflectorToItsTarget) {
  TrackerLoop loop{model, wanted, q};
  run(loop, [&](const JointVector& at) { return truth.predict(at, 0); });
  EXPECT_THAT(loop.end(), Optional(TrackerLoopEnd::Reached));
  EXPECT_GT(loop.errors_mm()[0], 0.1);
  EXPECT_LT(loop.errors_mm()[1], 0.005);
  EXPECT_LT((truth.predict(loop.q(), 0) - wanted).norm(), 0.001);
}

TEST_F(TrackerLoopTest, FollowsTheMeanOfItsReadingsAndNotTheirNoise) {
  constexpr double kSigma_mm = 0.02;
  constexpr int kTrials = 200, kRounds = 6;
  double squares = 0;
  for (int trial = 0; trial < kTrials; ++trial) {
    TrackerLoop loop{model, wanted, q, {.rounds = kRounds, .tolerance_mm = 0}};
    run(loop,
        [&](const JointVector& at) -> Eigen::Vector3d { return truth.predict(at, 0) + noise(kSigma_mm); });
    squares += (truth.predict(loop.q(), 0) - wanted).squaredNorm();
  }
  const double of_the_mean_mm = kSigma_mm * std::sqrt(3.0 / kRounds);
  EXPECT_NEAR(std::sqrt(squares / kTrials), of_the_mean_mm, 0.15 * of_the_mean_mm);
}

TEST_F(TrackerLoopTest, EndsOnceTheMeanOfItsReadingsIsWithinTheTolerance) {
  TrackerLoop loop{model, wanted, q, {.rounds = 20, .tolerance_mm = 0.01}};
  run(loop, [&](const JointVector& at) -> Eigen::Vector3d { return truth.predict(at, 0) + noise(0.02); });
  EXPECT_THAT(loop.end(), Optional(TrackerLoopEnd::Reached));
  EXPECT_LE(loop.averaged_error_mm(), 0.01);
  EXPECT_LT(loop.errors_mm().size(), 12U);
}

TEST_F(TrackerLoopTest, EndsWithTheBestJointsWhereTheErrorDoesNotFall) {
  TrackerLoop loop{model, wanted, q};
  double error_mm = 0.1;
  run(loop, [&](const JointVector&) -> Eigen::Vector3d {
    return wanted + Eigen::Vector3d{error_mm *= 3, 0, 0};
  });
  EXPECT_THAT(loop.end(), Optional(TrackerLoopEnd::DoesNotFall));
  EXPECT_THAT(loop.errors_mm(), SizeIs(4));
  EXPECT_EQ(loop.q(), q) << "where the error was least";
}

TEST_F(TrackerLoopTest, EndsAfterItsRoundsAtTheLatest) {
  TrackerLoop loop{model, wanted, q, {.rounds = 4, .tolerance_mm = 0}};
  run(loop, [&](const JointVector&) -> Eigen::Vector3d { return wanted + Eigen::Vector3d{0.2, 0, 0}; });
  EXPECT_THAT(loop.end(), Optional(TrackerLoopEnd::RoundsUsed));
  EXPECT_THAT(loop.errors_mm(), SizeIs(4));
}

TEST_F(TrackerLoopTest, KeepsTheJointsWhereACorrectionWouldLeadBeyondTheirLimits) {
  for (std::size_t i = 0; i < 6; ++i) {
    model.robot.joints[i].min = q[static_cast<Eigen::Index>(i)];
    model.robot.joints[i].max = q[static_cast<Eigen::Index>(i)];
  }
  TrackerLoop loop{model, wanted, q};
  loop.add(wanted + Eigen::Vector3d{0.5, 0, 0});
  EXPECT_THAT(loop.end(), Optional(TrackerLoopEnd::OutOfReach));
  EXPECT_EQ(loop.q(), q);
}

TEST_F(TrackerLoopTest, KeepsTheJointsWhereAnErrorIsNotThatOfAnArm) {
  TrackerLoop loop{model, wanted, q};
  loop.add(wanted + Eigen::Vector3d{400, 0, 0});
  EXPECT_THAT(loop.end(), Optional(TrackerLoopEnd::OutOfReach));
  EXPECT_EQ(loop.q(), q);
}

struct TrackerLoopOnARail : TrackerLoopTest {
  TrackerLoopOnARail() : TrackerLoopTest(example::kr210_on_a_rail()) {}
};

TEST_F(TrackerLoopOnARail, MovesSlidesAndTurningJointsByComparableParts) {
  q[0] = 1000;
  wanted = model.predict(q, 0);
  TrackerLoop loop{model, wanted, q};
  run(loop, [&](const JointVector& at) { return truth.predict(at, 0); });
  EXPECT_THAT(loop.end(), Optional(TrackerLoopEnd::Reached));
  const JointVector moved = (loop.q() - q).cwiseAbs();
  EXPECT_GT(moved[0], 1e-3);
  EXPECT_THAT(moved[0], Le(1));
}

}  // namespace
}  // namespace truepose
