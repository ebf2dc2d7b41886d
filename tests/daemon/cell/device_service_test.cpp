#include "daemon/cell/device_service.hpp"

#include "tests/daemon/cell_fixture.hpp"

namespace truepose::daemon {
namespace {

using namespace std::chrono_literals;
using testing::HasSubstr;

struct DeviceServiceTest : CellTest {
  /// The cell's waiting state this long after the command to connect.
  boost::json::value waiting_after(drivers::Duration time) {
    boost::json::value waiting;
    play([&]() -> Wait {
      send("cell.connect");
      co_await pass(time);
      const Answer now = co_await ask("cell.status");
      waiting = now->at("waiting");
      EXPECT_EQ(now->at("state"), "connecting");
      co_await pass(1min);
    });
    return waiting;
  }
};

TEST_F(DeviceServiceTest, ConnectsAndSaysWhichArmAndWhichTrackerTheseAre) {
  play([this]() -> Wait {
    co_await connected();
    co_await pass(2s);
  });
  const boost::json::value now = status();
  EXPECT_EQ(now.at("state"), "ready");
  EXPECT_EQ(now.at_pointer("/robot/serial"), "MOCK-0001");
  EXPECT_EQ(now.at_pointer("/robot/ready"), true);
  EXPECT_EQ(now.at_pointer("/tracker/serial"), "MOCK-0002");
  EXPECT_TRUE(now.at("waiting").is_null());
  ASSERT_TRUE(call("cell.disconnect"));
  EXPECT_EQ(status().at_pointer("/robot/why_not_ready"), "not connected");
  EXPECT_FALSE(robot.connected());
}

TEST_F(DeviceServiceTest, SaysThatItWaitsForTheController) {
  const boost::json::value waiting = waiting_after(100ms);
  EXPECT_EQ(waiting.at("device"), "controller");
  EXPECT_EQ(waiting.at("since"), "1970-01-01T00:00:00.000Z");
}

TEST_F(DeviceServiceTest, SaysThatItWaitsForTheTracker) {
  const boost::json::value waiting = waiting_after(10s);
  EXPECT_EQ(waiting.at("device"), "tracker");
  EXPECT_EQ(waiting.at("since"), "1970-01-01T00:00:00.212Z") << "since the controller answered";
}

TEST_F(DeviceServiceTest, DoesNotBecomeReadyOnceADisconnectWasRequested) {
  play([this]() -> Wait {
    send("cell.connect");
    co_await pass(1s);
    const Answer answer = co_await ask("cell.disconnect");
    EXPECT_EQ(answer->at("state"), "disconnected");
    co_await pass(1min);
  });
  EXPECT_EQ(status().at("state"), "disconnected");
}

TEST_F(DeviceServiceTest, IsAFaultWhereTheControllerCannotBeReachedUntilThatIsAcknowledged) {
  robot.leave(1h);
  EXPECT_THAT(refused("cell.connect"), HasSubstr("robot: the controller does not answer"));
  EXPECT_EQ(status().at("state"), "fault");
  EXPECT_EQ(status().at_pointer("/faults/0/code"), "E_CELL");
  EXPECT_THAT(refused("cell.connect"), HasSubstr("not possible in state fault; allowed: cell.acknowledge"));
  ASSERT_TRUE(call("cell.acknowledge"));
  EXPECT_EQ(status().at("state"), "disconnected");
  EXPECT_EQ(fault(), "");
}

TEST_F(DeviceServiceTest, NoticesWithinSecondsThatADeviceOfAReadyCellIsGone) {
  for (const bool is_robot : {true, false}) {
    play([&]() -> Wait {
      co_await connected();
      co_await pass(10s);
      is_robot ? robot.disconnect() : tracker.disconnect();
      co_await pass(is_robot ? 2s : 6s);
    });
    EXPECT_THAT(fault(), testing::StartsWith(is_robot ? "robot: not connected; look on the pendant"
                                                      : "tracker: not connected; see whether"));
    EXPECT_THAT(fault(), testing::EndsWith(", then acknowledge the fault and connect"));
    ASSERT_TRUE(call("cell.acknowledge"));
  }
}

TEST_F(DeviceServiceTest, HandsOutItsConfiguration) {
  const boost::json::value handed_out = call("system.config").value().at("config");
  EXPECT_EQ(handed_out.at("name"), "example");
  EXPECT_EQ(handed_out.at_pointer("/robot/expect_model"), "KR210R2700_2");
  EXPECT_EQ(handed_out.at_pointer("/campaign/identify_poses"), 16);
  EXPECT_EQ(handed_out.at_pointer("/stream/timeout_cycles"), 100);
}

TEST_F(CellTest, RefusesAParameterThatItDoesNotKnowInEveryMethod) {
  for (const std::string& method : cell.methods()) {
    const Answer answer = call(method, {{"nonsense", 1}});
    ASSERT_FALSE(answer) << method;
    EXPECT_EQ(answer.error().code, control::ErrorCode::InvalidParams) << method;
  }
  EXPECT_EQ(call("cell.dance").error().code, control::ErrorCode::MethodNotFound);
}

}  // namespace
}  // namespace truepose::daemon
