#pragma once

#include "daemon/realtime/stream_status.hpp"
#include "tests/daemon/stream_rig.hpp"

namespace truepose::daemon {

inline constexpr int kRampCycles = 250;
inline const RobotModel kFarOff = real_arm(20);  // corrections of more than a degree

/// Starts a correction, and continues until it is whole.
inline void correct(StreamRig& rig, const RobotModel& arm = kFarOff) {
  rig.settle();
  rig.cycle->use_model(arm, 1);
  rig.cycle->engage();
  rig.ticks(kRampCycles + 2);
  ASSERT_EQ(rig.state(), StreamState::Active) << reason(rig.status());
}

}  // namespace truepose::daemon
