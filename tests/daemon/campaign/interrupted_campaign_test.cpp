#include <utility>

#include "daemon/store/campaign_plan.hpp"
#include "tests/daemon/campaign_service_fixture.hpp"

namespace truepose::daemon {
namespace {

namespace json = boost::json;
using namespace std::chrono_literals;
using testing::AllOf;
using testing::HasSubstr;

struct InterruptedCampaignTest : CampaignServiceTest {
  /// Stops the daemon in the middle of a campaign. @return its id
  std::string interrupted(json::object params = {}) {
    play([&]() -> Wait {
      const Answer started = co_await ask("campaign.start", params);
      EXPECT_TRUE(started) << started.error().message;
      while (event_data(control::Topic::Measurement).size() < 7) co_await pass(1s);
      co_await cell.shut_down();
      // The daemon that comes after finds the devices disconnected and has no fault.
      co_await pass(10s);
      co_await ask("cell.acknowledge");
    });
    return store->last_campaign().value()->id;
  }
  /// Goes on with it to its end.
  Wait resumed(std::string id) {
    const json::object which{{"id", id}};
    co_await ask("campaign.resume", which);
    co_await campaign_ended();
  }
};

TEST_F(InterruptedCampaignTest, TheDaemonThatIsStoppedInterruptsTheCampaignFirst) {
  play([this]() -> Wait {
    co_await under_way();
    const TimePoint asked = clock.now();
    co_await cell.shut_down();
    EXPECT_LT(clock.now() - asked, 1s) << "no longer than that takes";
  });
  EXPECT_FALSE(robot.connected());
  const CampaignRecord kept = store->last_campaign().value().value();
  EXPECT_EQ(kept.state, "interrupted");
  EXPECT_EQ(kept.reason, "the daemon was stopped");
  EXPECT_EQ(phases().back(), "interrupted");
}

TEST_F(InterruptedCampaignTest, GoesOnWithACampaignThatWasInterruptedAndSaysSo) {
  const std::string id = interrupted();
  json::value now = status();
  EXPECT_EQ(string_at(now, "/interrupted/0/id"), id);
  EXPECT_EQ(now.at_pointer("/interrupted/0/kind"), "calibration");
  EXPECT_EQ(now.at_pointer("/interrupted/0/total"), 28);
  const std::int64_t done = now.at_pointer("/interrupted/0/done").as_int64();
  EXPECT_GT(done, 1);
  EXPECT_THAT(control::json_text(now.at("allowed")), HasSubstr("campaign.resume"));
  EXPECT_THAT(refused("campaign.resume"),
              AllOf(HasSubstr("no campaign is paused; interrupted: calibration " + id),
                    HasSubstr("give its id to resume it")));

  const std::size_t events_before = event_data(control::Topic::Measurement).size();
  play([this, id, done]() -> Wait {
    const json::object which{{"id", id}};
    const Answer resumed = co_await ask("campaign.resume", which);
    EXPECT_TRUE(resumed) << resumed.error().message;
    EXPECT_EQ(string_at(*resumed, "/id"), id);
    EXPECT_EQ(resumed->at("done"), done) << "before it has connected";
    EXPECT_EQ(resumed->at("total"), 28);
    EXPECT_EQ(resumed->at("left"), 28 - done);
    co_await campaign_ended();
  });
  const json::value campaign = call("campaign.get", {{"id", id}, {"points_limit", 100}}).value();
  EXPECT_EQ(campaign.at_pointer("/campaign/state"), "done") << control::json_text(campaign.at("campaign"));
  EXPECT_EQ(campaign.at_pointer("/campaign/reason"), "");
  EXPECT_EQ(campaign.at("points_total"), 28 + 2) << "two were measured again";
  EXPECT_EQ(event_data(control::Topic::Measurement).size(),
            events_before + 28 - static_cast<std::size_t>(done));
  EXPECT_THAT(string_at(campaign, "/interruptions/0/found"), HasSubstr("nothing has moved"));
  EXPECT_EQ(status().at_pointer("/model/id"), campaign.at_pointer("/campaign/model_id"));
  EXPECT_TRUE(status().at("interrupted").as_array().empty());
  const json::value report = call("report.get", {{"id", id}}).value();
  EXPECT_THAT(string_at(report, "/document/interruptions/0/found"), HasSubstr("nothing has moved"));
  EXPECT_EQ(refused("campaign.resume", {{"id", id}}), "no campaign " + id + " was interrupted");
}

TEST_F(InterruptedCampaignTest, GoesOnWithWhatItWasOrderedToDo) {
  const std::string id =
      interrupted({{"identify_poses", 12}, {"validate_poses", 3}, {"activate", false}, {"remeasure", true}});
  config.campaign.identify_poses = 40;  // in the cell file, meanwhile
  play([this, id]() -> Wait { co_await resumed(id); });
  const json::value campaign = call("campaign.get").value();
  EXPECT_EQ(campaign.at_pointer("/campaign/state"), "done");
  const auto skipped = static_cast<std::int64_t>(campaign.at("skipped").as_array().size());
  EXPECT_EQ(campaign.at("points_total").to_number<std::int64_t>() + skipped, 12 + 3 + 3 + 2)
      << "two were measured again";
  EXPECT_EQ(status().at_pointer("/model/id"), "m1");
}

TEST_F(InterruptedCampaignTest, EndsACampaignThatWasInterruptedWhereNobodyWantsIt) {
  const std::string id = interrupted();
  const json::value aborted = call("campaign.abort", {{"id", id}}).value();
  EXPECT_EQ(aborted.at("phase"), "aborted");
  EXPECT_EQ(string_at(aborted, "/id"), id);
  EXPECT_EQ(store->campaign(id).value()->state, "aborted");
  EXPECT_TRUE(status().at("interrupted").as_array().empty());
  EXPECT_EQ(phases().back(), "aborted");
  EXPECT_EQ(refused("campaign.abort", {{"id", id}}), "no campaign " + id + " was interrupted");
}

TEST_F(InterruptedCampaignTest, StaysInterruptedAndSaysWhyWhereItCannotGoOn) {
  const std::string id = interrupted();
  execute("UPDATE campaign SET robot_serial='4711' WHERE state='interrupted'");
  const JointVector stands = mock.q();
  play([this, id]() -> Wait { co_await resumed(id); });
  EXPECT_EQ(mock.q(), stands);
  const json::value campaign = call("campaign.get", {{"id", id}}).value();
  EXPECT_EQ(campaign.at_pointer("/campaign/state"), "interrupted");
  EXPECT_THAT(string_at(campaign, "/campaign/reason"), HasSubstr("it did not resume: another arm"));
  EXPECT_THAT(fault(), HasSubstr("another arm"));
  EXPECT_EQ(string_at(status(), "/interrupted/0/id"), id);
}

TEST_F(InterruptedCampaignTest, TellsWhyItDidNotGoOnRatherThanWhyItWasInterruptedBefore) {
  const std::string id = interrupted();
  EXPECT_EQ(string_at(status(), "/interrupted/0/reason"), "the daemon was stopped");
  const double ceiling_mm = std::exchange(config.workspace.max_mm.z(), 900);
  const std::string why = refused("campaign.resume", {{"id", id}});
  EXPECT_THAT(why, AllOf(HasSubstr("cannot resume in this cell: pose "), HasSubstr("correct the cell file")));
  EXPECT_EQ(status().at("state"), "disconnected");
  EXPECT_EQ(string_at(status(), "/interrupted/0/id"), id);
  EXPECT_EQ(string_at(status(), "/interrupted/0/reason"), why);
  EXPECT_EQ(string_at(event_data(control::Topic::Campaign).back(), "/reason"), why);
  const auto campaign = [&] { return call("campaign.get", {{"id", id}}).value().at("campaign"); };
  EXPECT_EQ(string_at(campaign(), "/state"), "interrupted");
  EXPECT_EQ(string_at(campaign(), "/reason"), why);
  EXPECT_TRUE(finish(cell.load_interrupted_campaigns()));
  EXPECT_EQ(string_at(status(), "/interrupted/0/reason"), why) << "to the daemon that comes after too";
  config.workspace.max_mm.z() = ceiling_mm;
  play([this, id]() -> Wait { co_await resumed(id); });
  EXPECT_EQ(string_at(campaign(), "/state"), "done");
  EXPECT_EQ(string_at(campaign(), "/reason"), "");
}

TEST_F(InterruptedCampaignTest, ADriftCheckIsNotInterruptedButAborted) {
  play([this]() -> Wait {
    co_await ask("drift.check");
    co_await pass(40s);
    co_await cell.shut_down();
  });
  EXPECT_EQ(store->last_campaign().value()->state, "aborted");
  EXPECT_THAT(store->last_campaign().value()->reason,
              HasSubstr("the daemon was stopped; a drift check asks"));
  EXPECT_TRUE(status().at("interrupted").as_array().empty());
}

}  // namespace
}  // namespace truepose::daemon
