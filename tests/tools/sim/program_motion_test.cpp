#include "tools/sim/program_motion.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <optional>
#include <vector>

#include "core/arm/forward.hpp"
#include "core/math/angles.hpp"
#include "tests/tools/sim/kr210.hpp"

namespace truepose::sim {
namespace {

constexpr Seconds kStep{0.004};
const JointVector kUpright = deg(0, -80, 105, 5, 60, 0);

/// Motions of an arm without tool or base, numbered as they come.
class ProgramMotionTest : public testing::Test {
 protected:
  krl::Motion lin(double x, double y, double z, bool approximated = false) {
    krl::Motion motion{.number = ++motions_, .kind = krl::MotionKind::Lin};
    krl::PoseTarget target;
    target.pose = {x, y, z, 0.0, 0.0, 180.0};
    motion.target = target;
    motion.path_velocity_m_s = 0.5;
    motion.path_acceleration_m_s2 = 2;
    if (approximated) {
      motion.approximation = krl::Approximation::Dis;
      motion.approximation_distance_mm = 30;
    }
    return motion;
  }
  krl::Motion ptp(const std::vector<double>& axes_deg, krl::MotionKind kind = krl::MotionKind::Ptp) {
    krl::Motion motion{.number = ++motions_, .kind = kind};
    motion.velocity_percent.fill(100);
    krl::AxisTarget target;
    for (std::size_t i = 0; i < axes_deg.size(); ++i) target.axes[i] = axes_deg[i];
    motion.target = target;
    return motion;
  }
  void take(const krl::Motion& motion, bool reduced = false) {
    const auto taken = arm.take(motion, reduced);
    ASSERT_TRUE(taken) << taken.error();
  }
  Eigen::Vector3d tcp_mm() const { return forward_kinematics(kr210(), arm.position()).translation(); }
  /// Until the arm stands. @return the positions of the TCP
  std::vector<Eigen::Vector3d> run() {
    std::vector<Eigen::Vector3d> way{tcp_mm()};
    while (!arm.is_standing() && way.size() < 20'000) {
      arm.advance(kStep);
      way.push_back(tcp_mm());
    }
    return way;
  }

  ProgramMotion arm = ProgramMotion::of(kr210(), kUpright).value();

 private:
  std::uint64_t motions_ = 0;
};

double nearest_mm(const std::vector<Eigen::Vector3d>& way, const Eigen::Vector3d& point) {
  double nearest = INFINITY;
  for (const Eigen::Vector3d& at : way) nearest = std::min(nearest, (at - point).norm());
  return nearest;
}

/// Greatest change of the way from one cycle to the next, and of that change: mm.
std::pair<double, double> greatest_step_and_jerk(const std::vector<Eigen::Vector3d>& way) {
  double step = 0, change = 0;
  for (std::size_t i = 2; i < way.size(); ++i) {
    step = std::max(step, (way[i] - way[i - 1]).norm());
    change = std::max(change, (way[i] - 2 * way[i - 1] + way[i - 2]).norm());
  }
  return {step, change};
}

TEST_F(ProgramMotionTest, StandsAtEveryPointThatIsNotApproximated) {
  take(lin(1700, 0, 1200));
  run();
  take(lin(1700, 300, 1200));
  take(lin(1500, 300, 1200));
  const auto way = run();
  EXPECT_LT(nearest_mm(way, {1700, 300, 1200}), 1e-6);
  EXPECT_LE(greatest_step_and_jerk(way).first, 0.5 * 4 + 1e-6) << "mm in a cycle at 0.5 m/s";
}

TEST_F(ProgramMotionTest, PassesAnApproximatedPointWithinItsDistanceWithoutAJumpOfSpeed) {
  take(lin(1700, 0, 1200));
  run();
  take(lin(1700, 300, 1200, true));
  take(lin(1500, 300, 1200));
  const auto way = run();
  const double missed_mm = nearest_mm(way, {1700, 300, 1200});
  EXPECT_GT(missed_mm, 3);
  EXPECT_LT(missed_mm, 30);
  EXPECT_LT((way.back() - Eigen::Vector3d{1500, 300, 1200}).norm(), 1e-6);
  const auto [step, change] = greatest_step_and_jerk(way);
  EXPECT_LT(step, 0.5 * 4 * 1.1);
  EXPECT_LT(change, 2 * 2 * 0.016) << "2 m/s^2 for each motion, in a cycle of 4 ms";
  for (std::uint64_t motion = 1; motion <= 3; ++motion) EXPECT_TRUE(arm.is_finished(motion));
}

TEST_F(ProgramMotionTest, StopsAtAnApproximatedPointWhereNoMotionFollowsInTime) {
  take(lin(1700, 0, 1200));
  run();
  take(lin(1700, 300, 1200, true));
  EXPECT_LT((run().back() - Eigen::Vector3d{1700, 300, 1200}).norm(), 1e-6);
}

TEST_F(ProgramMotionTest, GoesRelativelyFromWhereTheMotionBeforeEnds) {
  take(ptp({10, -80, 105, 5, 60, 0}));
  take(ptp({5}, krl::MotionKind::PtpRel));
  run();
  EXPECT_NEAR(arm.position()[0], 15 * kRadPerDeg, 1e-12);
  EXPECT_NEAR(arm.position()[1], -80 * kRadPerDeg, 1e-12);
}

TEST_F(ProgramMotionTest, IsSlowInT1) {
  take(ptp({90, -80, 105, 5, 60, 0}), true);
  const double slow_s = static_cast<double>(run().size()) * kStep.count();
  EXPECT_GT(slow_s, 90 / 11.7);
  take(ptp({0, -80, 105, 5, 60, 0}));
  take(lin(1700, 0, 1200));
  run();
  take(lin(1700, 300, 1200), true);
  EXPECT_LE(greatest_step_and_jerk(run()).first, 0.25 * 4 + 1e-6);
}

TEST_F(ProgramMotionTest, RefusesWhatItCannotReachOrIsNotSimulated) {
  EXPECT_FALSE(arm.take(lin(9000, 0, 0)));
  EXPECT_FALSE(arm.take(ptp({0, 10, 90, 0, 0, 0})));
  krl::Motion circle = lin(1700, 0, 1200);
  circle.kind = krl::MotionKind::Circ;
  circle.circle_angle_deg = 90;
  EXPECT_EQ(arm.take(circle).error(), "CA of CIRC is not simulated");
}

}  // namespace
}  // namespace truepose::sim
