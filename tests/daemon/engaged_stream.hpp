#pragma once

#include <gtest/gtest.h>

#include "core/compensate/target_compensation.hpp"
#include "tests/daemon/stream_rig.hpp"

namespace truepose::daemon {

inline constexpr double kWireDeg = 1.01e-6;  // what six decimals can be off
inline constexpr int kRamp = 250;            // cycles

inline JointVector expected_correction(const RobotModel& model, const JointVector& q) {
  return TargetCompensation(nominal_arm(), model).at_joints(q)->q - q;
}

inline void expect_near_deg(const JointVector& actual, const JointVector& expected, double tolerance_deg) {
  EXPECT_LE((actual - expected).cwiseAbs().maxCoeff() * kDegPerRad, tolerance_deg)
      << "actual " << actual.transpose() * kDegPerRad << "\nexpected " << expected.transpose() * kDegPerRad;
}

/// A stream with the real arm's model, all the way in.
inline void engage(StreamRig& rig, const RobotModel& model = real_arm()) {
  rig.settle();
  rig.cycle->use_model(model, 1);
  rig.cycle->engage();
  rig.ticks(kRamp + 2);
  ASSERT_EQ(rig.state(), StreamState::Active);
  ASSERT_GT(rig.largest_applied_deg(), 0.02);
}

inline int count_events(StreamCycle& cycle, StreamEventKind kind) {
  int count = 0;
  for (StreamEvent event; cycle.next_event(event);) count += event.kind == kind;
  return count;
}

}  // namespace truepose::daemon
