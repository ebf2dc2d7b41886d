#include "tools/sim/motion/program_motion.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include "core/arm/forward.hpp"
#include "core/math/angles.hpp"
#include "tests/tools/sim/kr210.hpp"

namespace truepose::sim {
namespace {

constexpr Seconds kStep{0.004};
const Eigen::Vector3d kCentre{1500, 0, 1200};
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
  krl::Motion spl(double x, double y, double z) {
    krl::Motion motion = lin(x, y, z);
    motion.kind = krl::MotionKind::Spl;
    return motion;
  }
  krl::Motion arc(const Eigen::Vector3d& via, const Eigen::Vector3d& to) {
    krl::Motion motion = lin(to.x(), to.y(), to.z());
    motion.kind = krl::MotionKind::Circ;
    motion.via = krl::PoseTarget{.pose = {via.x(), via.y(), via.z()}};
    return motion;
  }
  krl::Motion spline(std::vector<krl::Motion> segments) {
    return {.number = ++motions_, .kind = krl::MotionKind::Spline, .segments = std::move(segments)};
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

TEST_F(ProgramMotionTest, GoesAlongTheAxesOfTheTool) {
  take(ptp({0, -90, 90, 0, 45, 30}));
  run();
  const Eigen::Isometry3d before = forward_kinematics(kr210(), arm.position());
  krl::Motion motion{.number = 99, .kind = krl::MotionKind::LinRel};
  motion.is_in_tool = true;
  motion.target = krl::PoseTarget{.pose = {10.0, -20.0, 30.0}};
  take(motion);
  run();
  EXPECT_LT((tcp_mm() - before * Eigen::Vector3d{10, -20, 30}).norm(), 1e-6);
}

/// How long the arm takes up to a point, from the way that it went.
double seconds_to(const std::vector<Eigen::Vector3d>& way, const Eigen::Vector3d& point) {
  const auto nearest =
      std::ranges::min_element(way, {}, [&](const Eigen::Vector3d& p) { return (p - point).norm(); });
  return kStep.count() * static_cast<double>(nearest - way.begin());
}

TEST_F(ProgramMotionTest, TakesTheTimesOfTheBlockForItsParts) {
  const Eigen::Vector3d a{1500, 0, 1200}, b{1500, 100, 1200}, c{1500, 400, 1200};
  take(lin(a.x(), a.y(), a.z()));
  run();
  krl::Motion first = spl(b.x(), b.y(), b.z()), second = spl(c.x(), c.y(), c.z());
  for (krl::Motion* segment : {&first, &second}) segment->path_acceleration_m_s2 = 20;
  first.time_percent = 60;
  second.time_percent = 40;
  second.time_s = 4;
  take(spline({first, second}));
  const std::vector<Eigen::Vector3d> way = run();
  EXPECT_NEAR(seconds_to(way, b), 2.4, 0.02) << "100 mm in 60 %";
  EXPECT_NEAR(seconds_to(way, c), 4.0, 0.02) << "300 mm in 40 %";
}

TEST_F(ProgramMotionTest, IsAsSlowAsItsVelocityWhateverTheTimesOfTheBlock) {
  take(lin(1500, 0, 1200));
  run();
  krl::Motion segment = spl(1500, 500, 1200);  // 0.5 m/s
  segment.time_percent = 100;
  segment.time_s = 0.1;
  take(spline({segment}));
  EXPECT_GT(kStep.count() * static_cast<double>(run().size()), 1.0);
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
  krl::Motion circle = arc({1700, 0, 1200}, {1600, 0, 1200});
  circle.circle_angle_deg = 90;
  EXPECT_EQ(arm.take(lin(1500, 0, 1200)), (std::expected<void, std::string>{}));
  EXPECT_EQ(arm.take(circle).error(), "CA needs three points that are not in one line");
  krl::Motion block = spline({spl(1600, 0, 1200), spl(1600, 0, 1100)});
  block.segments[1].base = krl::FrameValues{1, 0, 0, 0, 0, 0};
  EXPECT_EQ(arm.take(block).error(), "another $TOOL or $BASE inside of a spline block is not simulated");
  krl::Motion motion = ptp({0, -80, 105, 5, 60, 0});
  motion.switching = {{.number = 1, .path_mm = -5}};
  EXPECT_EQ(arm.take(motion).error(),
            "PATH of TRIGGER is 0 before motions of the axes, which have no path to count along");
}

TEST_F(ProgramMotionTest, GoesAroundACircleByItsAngle) {
  take(lin(1700, 0, 1200));
  run();
  for (const double angle_deg : {90.0, -90.0, 270.0, 540.0}) {
    take(lin(1700, 0, 1200));
    run();
    krl::Motion circle = arc({1500, 0, 1400}, {1300, 0, 1200});
    circle.circle_angle_deg = angle_deg;
    take(circle);
    const auto way = run();
    double turned_rad = 0;
    for (std::size_t i = 1; i < way.size(); ++i) {
      const Eigen::Vector3d before = way[i - 1] - kCentre, now = way[i] - kCentre;
      EXPECT_NEAR(now.norm(), 200, 1e-6);
      turned_rad -= std::asin(before.cross(now).y() / 200 / 200);
    }
    EXPECT_NEAR(turned_rad * kDegPerRad, angle_deg, 0.01);
  }
}

TEST_F(ProgramMotionTest, GoesThroughEveryPointOfASplineWithoutACorner) {
  take(lin(1700, 0, 1200));
  run();
  const std::vector<Eigen::Vector3d> points{{1650, 100, 1250}, {1600, 250, 1200}, {1500, 300, 1100}};
  krl::Motion block = spline({});
  for (const Eigen::Vector3d& p : points) block.segments.push_back(spl(p.x(), p.y(), p.z()));
  take(block);
  const auto way = run();
  for (const Eigen::Vector3d& point : points) EXPECT_LT(nearest_mm(way, point), 1) << "half a cycle's way";
  EXPECT_LT((way.back() - points.back()).norm(), 1e-6);
  const auto [step, change] = greatest_step_and_jerk(way);
  EXPECT_LT(step, 0.5 * 4 * 1.01);
  EXPECT_LT(change, 0.05) << "no corner: mm in a cycle";
}

TEST_F(ProgramMotionTest, LeavesLinesAndArcsOfASplineAlongTheirDirection) {
  take(lin(1700, 0, 1200));
  run();
  krl::Motion block = spline({lin(1700, 150, 1200), spl(1600, 250, 1200), lin(1400, 250, 1200)});
  take(block);
  const auto way = run();
  EXPECT_LT(greatest_step_and_jerk(way).second, 0.1) << "a bend, no corner";
  double off_line_mm = 0;
  for (const Eigen::Vector3d& at : way) {
    if (at.y() < 150) off_line_mm = std::max(off_line_mm, std::abs(at.x() - 1700));
    if (at.x() < 1600) off_line_mm = std::max(off_line_mm, std::abs(at.y() - 250));
  }
  EXPECT_LT(off_line_mm, 1e-6);
}

TEST_F(ProgramMotionTest, StopsInTheCornersOfASpline) {
  take(lin(1700, 0, 1200));
  run();
  take(spline({lin(1700, 200, 1200), lin(1500, 200, 1200)}));
  const auto way = run();
  EXPECT_LT(nearest_mm(way, {1700, 200, 1200}), 0.02);
  EXPECT_LT(greatest_step_and_jerk(way).second, 2 * 0.016 * 1.5);
}

TEST_F(ProgramMotionTest, KeepsTheSpeedOfEachSegment) {
  take(lin(1700, -200, 1200));
  run();
  krl::Motion slow = lin(1700, 0, 1200), fast = lin(1700, 200, 1200);
  slow.path_velocity_m_s = 0.1;
  take(spline({slow, fast}));
  const auto way = run();
  double slow_step = 0, fast_step = 0;
  for (std::size_t i = 1; i < way.size(); ++i)
    (way[i].y() < 0 ? slow_step : fast_step) =
        std::max(way[i].y() < 0 ? slow_step : fast_step, (way[i] - way[i - 1]).norm());
  EXPECT_NEAR(slow_step, 0.1 * 4, 1e-3);
  EXPECT_NEAR(fast_step, 0.5 * 4, 1e-3);
}

TEST_F(ProgramMotionTest, GoesThroughThePointsOfTheAxesWithoutStanding) {
  krl::Motion block =
      spline({ptp({10, -80, 105, 5, 60, 0}), ptp({20, -85, 105, 5, 60, 0}), ptp({30, -80, 105, 5, 60, 0})});
  block.kind = krl::MotionKind::PtpSpline;
  take(block);
  double nearest_rad = INFINITY, slowest_rad = INFINITY;
  JointVector before = arm.position();
  while (!arm.is_standing()) {
    const JointVector q = arm.advance(kStep);
    nearest_rad = std::min(nearest_rad, (q - deg(20, -85, 105, 5, 60, 0)).norm());
    if (q[0] > 5 * kRadPerDeg && q[0] < 25 * kRadPerDeg)
      slowest_rad = std::min(slowest_rad, q[0] - before[0]);
    before = q;
  }
  EXPECT_LT(nearest_rad, 0.003);
  EXPECT_GT(slowest_rad, 0.0005);
  EXPECT_LT((arm.position() - deg(30, -80, 105, 5, 60, 0)).norm(), 1e-12);
}

/// Where the TCP is when it switches.
class SwitchingTest : public ProgramMotionTest {
 protected:
  void SetUp() override {
    take(lin(1700, -200, 1200));
    run();
  }
  Eigen::Vector3d switched_mm() {
    for (int cycle = 0; cycle < 20'000; ++cycle) {
      arm.advance(kStep);
      if (!arm.take_switched().empty()) return tcp_mm();
    }
    ADD_FAILURE() << "nothing is switched";
    return {0, 0, 0};
  }
  krl::Motion switching(krl::Motion motion, krl::SwitchingPoint point) {
    point.number = 1;
    motion.switching = {point};
    return motion;
  }
};

TEST_F(SwitchingTest, IsDoneOnThePath) {
  take(switching(lin(1700, 200, 1200), {.path_mm = -100}));
  EXPECT_NEAR(switched_mm().y(), 100, 2);
  run();
  take(switching(lin(1700, -200, 1200), {.from_start = true, .path_mm = 50}));
  EXPECT_NEAR(switched_mm().y(), 150, 2);
  run();
  take(switching(lin(1700, 200, 1200), {.path_mm = -5000}));
  EXPECT_NEAR(switched_mm().y(), -200, 2) << "trimmed to the start";
}

TEST_F(SwitchingTest, IsDoneSoManyMillisecondsBefore) {
  take(switching(lin(1700, 200, 1200), {.path_mm = -100, .delay_s = -0.1}));
  EXPECT_NEAR(switched_mm().y(), 100 - 50, 2) << "0.5 m/s";
}

TEST_F(SwitchingTest, BehindThePointIsDoneInTheNextMotion) {
  take(switching(lin(1700, 0, 1200, true), {.path_mm = 80}));
  take(lin(1700, 200, 1200));
  EXPECT_NEAR(switched_mm().y(), 80, 2);
}

TEST_F(SwitchingTest, OfASegmentCountsFromItsEnd) {
  take(spline({switching(lin(1700, 0, 1200), {.path_mm = -40}), lin(1700, 200, 1200)}));
  EXPECT_NEAR(switched_mm().y(), -40, 2);
}

TEST_F(SwitchingTest, GoesOnWhileTheArmStands) {
  take(switching(ptp({0, -80, 105, 5, 60, 0}), {.delay_s = 0.1}));
  run();
  EXPECT_TRUE(arm.take_switched().empty());
  EXPECT_EQ(arm.until_change(kStep), kStep);
  arm.cancel();
  for (int cycle = 0; cycle < 25; ++cycle) arm.advance(kStep);
  EXPECT_EQ(arm.take_switched(), std::vector<std::uint64_t>{1});
  EXPECT_FALSE(arm.until_change(kStep));
}

}  // namespace
}  // namespace truepose::sim
