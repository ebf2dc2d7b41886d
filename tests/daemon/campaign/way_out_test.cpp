#include "daemon/campaign/way_out.hpp"

#include <gmock/gmock.h>

#include <utility>

#include "daemon/campaign/cell_devices.hpp"
#include "daemon/realtime/stream_status.hpp"

namespace truepose::daemon {
namespace {

using testing::EndsWith;
using testing::HasSubstr;
using testing::Not;

/// That a list has every enumerator: there is none behind its last.
template <typename Fault, std::size_t kSize>
Fault beyond(const std::array<Fault, kSize>& all) {
  return static_cast<Fault>(std::to_underlying(all.back()) + 1);
}

TEST(WayOut, OfEveryFaultOfARobotIsKnown) {
  for (const drivers::RobotFault fault : drivers::kRobotFaults) {
    const DeviceError error = device_error({fault, "it fails"});
    EXPECT_EQ(error.detail, "robot: it fails");
    EXPECT_FALSE(error.what_to_do.empty()) << std::to_underlying(fault);
  }
  EXPECT_EQ(way_out(beyond(drivers::kRobotFaults)), "");
}

TEST(WayOut, OfEveryFaultOfATrackerIsKnownWithABridgeAndWithout) {
  for (const auto protocol : {config::TrackerProtocol::Emscon, config::TrackerProtocol::Bridge}) {
    config::TrackerConfig tracker;
    tracker.protocol = protocol;
    for (const drivers::TrackerFault fault : drivers::kTrackerFaults) {
      const DeviceError error = device_error({fault, "it fails"}, tracker);
      EXPECT_EQ(error.detail, "tracker: it fails");
      EXPECT_FALSE(error.what_to_do.empty()) << std::to_underlying(fault);
    }
    EXPECT_EQ(way_out(beyond(drivers::kTrackerFaults), tracker), "");
  }
}

TEST(WayOut, OfEveryFaultOfTheStreamIsKnownAndEndsWithOneAcknowledgement) {
  for (const StreamFault fault : kStreamFaults) {
    const StreamStatus status{.state = StreamState::Fault, .fault = fault};
    const FaultText text = fault_text(status);
    EXPECT_THAT(text.what, Not(HasSubstr("acknowledge")));
    EXPECT_NE(text.what, "") << std::to_underlying(fault);
    EXPECT_NE(text.what_to_do, "") << text.what;
    EXPECT_THAT(reason(status), EndsWith("; " + text.what_to_do + ", then acknowledge"));
  }
  EXPECT_EQ(fault_text({.fault = beyond(kStreamFaults)}).what, "");
}

TEST(WayOut, OfARobotThatIsNotReadyIsInItsSentenceWhateverTheReason) {
  for (const char* why :
       {"emergency stop", "safety gate open", "drives off", "a stop message is pending on the pendant",
        "the robot program is not running", "tool 3 is active, the flange (0) is needed"}) {
    EXPECT_THAT(drivers::not_ready_text(why),
                testing::AllOf(testing::StartsWith("robot: " + std::string{why} + ": "),
                               HasSubstr("start truepose_motion"), HasSubstr("pendant")));
  }
}

}  // namespace
}  // namespace truepose::daemon
