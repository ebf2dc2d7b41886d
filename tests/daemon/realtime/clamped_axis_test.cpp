#include "daemon/realtime/clamped_axis.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "tests/daemon/corrected_stream.hpp"

namespace truepose::daemon {
namespace {

using testing::HasSubstr;
using Six = std::array<double, 6>;

StreamStatus frozen(const Six& sent_deg, const Six& measured_deg) {
  StreamStatus status{.state = StreamState::Frozen, .fault = StreamFault::NotFollowing};
  status.correction_deg = sent_deg;
  std::ranges::copy(measured_deg, status.measured_deg.begin());
  return status;
}

TEST(ClampedAxis, IsTheOneThatLacksMostOfThoseThatStandAtOneLimit) {
  const auto clamped =
      clamped_axis(frozen({0.7, -0.9, 0.1, 0.883, -0.3, -0.6}, {0.5, -0.5, 0.1, 0.501, -0.3, -0.499}));
  ASSERT_TRUE(clamped);
  EXPECT_EQ(clamped->axis, 2);
  EXPECT_EQ(clamped->sent_deg, -0.9);
  EXPECT_EQ(clamped->stands_deg, -0.5);
}

TEST(ClampedAxis, MayHaveOtherLimitsEachWay) {
  EXPECT_TRUE(clamped_axis(frozen({0.7, 0.9, -0.9, -0.8, 0, 0}, {0.5, 0.5, -0.3, -0.3, 0, 0})));
}

TEST(ClampedAxis, AloneStandsAtARoundNumber) {
  EXPECT_TRUE(clamped_axis(frozen({0, 0, 0.9, 0, 0, 0}, {0, 0, 0.5, 0, 0, 0})));
  EXPECT_FALSE(clamped_axis(frozen({0, 0, 0.9, 0, 0, 0}, {0, 0, 0.523, 0, 0, 0})));
}

TEST(ClampedAxis, IsNoneWhereTheCorrectionIsScaledTurnedRoundNotAppliedOrNotKnown) {
  EXPECT_FALSE(clamped_axis(frozen({0.6, 0.8, 0, 0, 0, 0}, {0.3, 0.4, 0, 0, 0, 0}))) << "half of it";
  EXPECT_FALSE(clamped_axis(frozen({0.6, 0, 0, 0, 0, 0}, {-0.5, 0, 0, 0, 0, 0})));
  EXPECT_FALSE(clamped_axis(frozen({0.6, 0.8, 0, 0, 0, 0}, {0, 0, 0, 0, 0, 0})));
  EXPECT_FALSE(clamped_axis(frozen({0.6, 0, 0, 0, 0, 0}, {0.7, 0, 0, 0, 0, 0}))) << "more than was sent";
  EXPECT_FALSE(clamped_axis(frozen({0.6, 0.8, 0, 0, 0, 0}, {0.6, 0.8, 0, 0, 0, 0}))) << "it follows";
  StreamStatus unknown = frozen({0.7, 0.9, 0, 0, 0, 0}, {0.5, 0.5, 0, 0, 0, 0});
  unknown.measured_deg[5].reset();
  EXPECT_FALSE(clamped_axis(unknown));
}

TEST(AClampedStream, SaysWhichAxisStandsAtWhichLimitAndWhatToDo) {
  constexpr double kLimit_deg = 0.5;
  StreamRig rig;
  rig.settle();
  rig.cycle->use_model(kFarOff, 1);
  rig.cycle->engage();
  for (int i = 0; i < 4 * kRampCycles; ++i) {
    rig.stuck = rig.q + rig.applied.cwiseMax(-kLimit_deg * kRadPerDeg).cwiseMin(kLimit_deg * kRadPerDeg);
    rig.tick();
  }
  const StreamStatus status = rig.status();
  ASSERT_EQ(status.state, StreamState::Frozen);
  Eigen::Index worst = 0;
  rig.applied.cwiseAbs().maxCoeff(&worst);
  EXPECT_THAT(reason(status),
              HasSubstr("the controller clamps the correction: A" + std::to_string(worst + 1) + " is sent "));
  EXPECT_THAT(reason(status),
              HasSubstr(rig.applied[worst] > 0 ? "stands at 0.50 deg" : "stands at -0.50 deg"));
  EXPECT_THAT(reason(status),
              HasSubstr("AXISCORR in its RSI context (LowerLim and UpperLim, or RSI's default)"));
  EXPECT_THAT(reason(status), HasSubstr("beyond stream.max_total_deg"));
}

}  // namespace
}  // namespace truepose::daemon
