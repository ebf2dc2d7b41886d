#include "tests/daemon/campaign_service_fixture.hpp"

namespace truepose::daemon {
namespace {

namespace json = boost::json;
using namespace std::chrono_literals;
using testing::AllOf;
using testing::HasSubstr;

struct TroubledCampaignTest : CampaignServiceTest {};

TEST_F(TroubledCampaignTest, PausesWhereADeviceStaysAwayAndGoesOnByItselfOnceItIsBack) {
  play([this]() -> Wait {
    co_await under_way();
    robot.disconnect();
    robot.leave(10min);
    co_await pass(40s);
    Answer now = co_await ask("cell.status");
    EXPECT_EQ(now->at("state"), "campaign");
    EXPECT_EQ(now->at_pointer("/robot/connected"), false);
    EXPECT_EQ(now->at_pointer("/tracker/connected"), true);
    EXPECT_EQ(now->at_pointer("/waiting/device"), "controller");
    EXPECT_THAT(string_at(*now, "/waiting/reason"), HasSubstr("robot: the controller does not answer"));
    EXPECT_THAT(string_at(*now, "/state_text"), HasSubstr("waiting for the controller, 3"));
    EXPECT_TRUE(now->at_pointer("/campaign/eta_s").is_null());
    co_await pass(100s);
    now = co_await ask("cell.status");
    EXPECT_EQ(now->at("state"), "paused");
    EXPECT_THAT(string_at(*now, "/state_text"),
                AllOf(HasSubstr("robot: the controller does not answer"), HasSubstr("resumes by itself")));
    co_await pass(9min);
    now = co_await ask("cell.status");
    EXPECT_EQ(now->at("state"), "campaign");
    EXPECT_TRUE(now->at("waiting").is_null());
    EXPECT_EQ(now->at_pointer("/robot/connected"), true);
    EXPECT_FALSE(now->at_pointer("/campaign/eta_s").is_null());
    co_await campaign_ended();
  });
  EXPECT_EQ(call("campaign.get")->at_pointer("/campaign/state"), "done");
  EXPECT_EQ(call("campaign.get")->at("points").as_array().size(), 0U);
  EXPECT_EQ(call("campaign.get")->at("points_total"), 28);
}

TEST_F(TroubledCampaignTest, TellsAnEmergencyStopWhileTheArmIsOnItsWay) {
  play([this]() -> Wait {
    co_await ask("campaign.start");
    while (!mock.moving()) co_await pass(100ms);
    robot.press_emergency_stop(true);
    co_await pass(2s);
    Answer now = co_await ask("cell.status");
    EXPECT_THAT(string_at(*now, "/waiting/reason"), testing::StartsWith("robot: emergency stop: release it"));
    EXPECT_EQ(now->at_pointer("/robot/connected"), true);
    EXPECT_EQ(now->at_pointer("/robot/ready"), false);
    co_await pass(3min);
    now = co_await ask("cell.status");
    EXPECT_EQ(now->at("state"), "paused");
    EXPECT_THAT(string_at(*now, "/state_text"), HasSubstr("robot: emergency stop"));
    robot.press_emergency_stop(false);
    co_await pass(5s);
    now = co_await ask("cell.status");
    EXPECT_EQ(now->at("state"), "campaign");
    co_await campaign_ended();
  });
  EXPECT_EQ(call("campaign.get")->at_pointer("/campaign/state"), "done");
}

TEST_F(TroubledCampaignTest, NoticesATrackerThatIsLostWhileItIsPaused) {
  play([this]() -> Wait {
    co_await under_way();
    co_await ask("campaign.pause");
    co_await pass(1min);
    tracker.disconnect();
    co_await pass(6s);
    Answer now = co_await ask("cell.status");
    EXPECT_EQ(now->at("state"), "paused");
    EXPECT_EQ(now->at_pointer("/tracker/connected"), false);
    EXPECT_EQ(now->at_pointer("/tracker/why_not_ready"), "not connected");
    EXPECT_EQ(now->at_pointer("/waiting/device"), "tracker");
    co_await ask("campaign.resume");
    co_await campaign_ended();
  });
  EXPECT_EQ(call("campaign.get")->at_pointer("/campaign/state"), "done");
}

TEST_F(TroubledCampaignTest, AStoreThatFailsIsAFaultUntilItIsAcknowledged) {
  play([this]() -> Wait {
    co_await under_way();
    execute("DROP TABLE point");
    co_await campaign_ended();
  });
  EXPECT_EQ(status().at("state"), "fault");
  EXPECT_THAT(fault(), AllOf(HasSubstr("store: "), HasSubstr("no such table")));
  EXPECT_EQ(call("cell.acknowledge")->at("state"), "disconnected");
}

}  // namespace
}  // namespace truepose::daemon
