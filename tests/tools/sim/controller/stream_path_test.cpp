#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <vector>

#include "tests/tools/sim/kr210.hpp"
#include "tools/sim/controller/rsi_client.hpp"

namespace truepose::sim {
namespace {

using namespace std::chrono_literals;

const JointVector kFirstPoint = deg(0, -90, 90, 0, 35, 0);

TEST(StreamPath, VisitsItsPointsInALoopWithoutAJump) {
  const std::vector<JointVector> points{kFirstPoint, deg(25, -80, 95, 20, 45, -30),
                                        deg(15, -65, 75, -15, 50, 40)};
  StreamPath path{kr210(), points, 0.5};
  EXPECT_TRUE(path.moving());
  std::vector<double> nearest(points.size(), 1);
  JointVector before = path.set_points();
  EXPECT_EQ(before, kFirstPoint);
  for (int cycle = 0; cycle < 5000; ++cycle) {
    path.advance(4ms, before, JointVector::Zero(6));
    const JointVector q = path.set_points();
    for (Eigen::Index i = 0; i < 6; ++i) {
      const double fastest = kr210().joints[static_cast<std::size_t>(i)].speed * 0.5 * 0.004;
      ASSERT_LE(std::abs(q[i] - before[i]), fastest * 1.000001) << "cycle " << cycle;
    }
    for (std::size_t k = 0; k < points.size(); ++k) nearest[k] = std::min(nearest[k], (q - points[k]).norm());
    before = q;
  }
  for (const double distance : nearest) EXPECT_LT(distance, 0.001);
}

TEST(StreamPath, StandsAtASinglePoint) {
  StreamPath path{kr210(), {kFirstPoint}, 1};
  path.advance(1s, kFirstPoint, JointVector::Zero(6));
  EXPECT_EQ(path.set_points(), kFirstPoint);
  EXPECT_FALSE(path.moving());
}

}  // namespace
}  // namespace truepose::sim
