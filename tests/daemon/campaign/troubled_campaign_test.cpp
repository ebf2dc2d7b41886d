#include <set>

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

TEST_F(TroubledCampaignTest, SaysWhichDevicesAreConnectedFromTheFirstOnes) {
  play([this]() -> Wait {
    co_await under_way(1s);
    Answer now = co_await ask("cell.status");
    EXPECT_EQ(now->at_pointer("/robot/connected"), true);
    EXPECT_EQ(now->at_pointer("/robot/serial"), "MOCK-0001");
    EXPECT_EQ(now->at_pointer("/tracker/connected"), false);
    co_await pass(1min);
    now = co_await ask("cell.status");
    EXPECT_EQ(now->at_pointer("/tracker/connected"), true);
    co_await ask("campaign.abort");
  });
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

TEST_F(TroubledCampaignTest, PausesItselfWhereSomebodyStandsInTheBeam) {
  play([this]() -> Wait {
    co_await under_way();
    mock.use_faults({.beam_broken = 1});
    co_await pass(5min);
    const Answer now = co_await ask("cell.status");
    EXPECT_EQ(now->at("state"), "paused");
    EXPECT_THAT(string_at(*now, "/state_text"), HasSubstr("2 poses in a row could not be measured"));
    mock.use_faults({});
    co_await ask("campaign.resume");
    co_await campaign_ended();
  });
  EXPECT_EQ(call("campaign.get")->at_pointer("/campaign/state"), "done");
}

/// What goes wrong, and whom the log blames.
struct Trouble {
  const char* kind;
  double drivers::MockFaults::*probability;
  const char* blamed;
};

void PrintTo(const Trouble& trouble, std::ostream* out) { *out << trouble.kind; }

struct ACampaignInTrouble : TroubledCampaignTest, testing::WithParamInterface<Trouble> {};

TEST_P(ACampaignInTrouble, EndsAndEveryPoseHasItsPointOrAReason) {
  int complaints = 0;
  read_log([&](LogLevel, std::string_view line) { complaints += line.contains(GetParam().blamed); });
  drivers::MockFaults faults;
  faults.*GetParam().probability = 0.2;
  mock.use_faults(faults);
  play([this]() -> Wait {
    co_await ask("campaign.start");
    for (Answer now = co_await ask("cell.status"); !now->at("campaign").is_null();
         now = co_await ask("cell.status")) {
      // Where the beam stays away the campaign waits for somebody who has looked at the cell.
      if (now->at("state") == "paused") co_await ask("campaign.resume");
      co_await pass(1s);
    }
  });
  read_log({});
  EXPECT_GT(complaints, 0);
  const json::value found = call("campaign.get", {{"points_limit", 100}}).value();
  EXPECT_EQ(found.at_pointer("/campaign/state"), "done");
  std::set<std::int64_t> poses;
  for (const json::value& point : found.at("points").as_array()) poses.insert(point.at("pose").as_int64());
  for (const json::value& skipped : found.at("skipped").as_array()) {
    EXPECT_NE(skipped.at("reason"), "");
    poses.insert(skipped.at("pose").as_int64());
  }
  EXPECT_GE(poses.size(), 28U) << "planned ones, and a substitute for each that was given up";
  EXPECT_EQ(*poses.rbegin(), static_cast<std::int64_t>(poses.size())) << "a pose has neither";
}

INSTANTIATE_TEST_SUITE_P(
    OfEveryKind, ACampaignInTrouble,
    testing::Values(Trouble{"BeamBreak", &drivers::MockFaults::beam_broken, "tracker: the beam was broken"},
                    Trouble{"TrackerRestart", &drivers::MockFaults::tracker_restart, "tracker: "},
                    Trouble{"EkiDrop", &drivers::MockFaults::robot_lost, "robot: "},
                    Trouble{"ControllerRestart", &drivers::MockFaults::robot_restart, "robot: "},
                    Trouble{"NoTarget", &drivers::MockFaults::no_target, "tracker: no reflector"}),
    [](const auto& kind) { return kind.param.kind; });

}  // namespace
}  // namespace truepose::daemon
