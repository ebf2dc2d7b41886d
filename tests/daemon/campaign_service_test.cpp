#include "daemon/cell/campaign_service.hpp"

#include <algorithm>
#include <set>

#include "daemon/store/campaign_plan.hpp"
#include "tests/daemon/cell_fixture.hpp"

namespace truepose::daemon {
namespace {

namespace json = boost::json;
using namespace std::chrono_literals;
using testing::AllOf;
using testing::HasSubstr;
using testing::SizeIs;

std::string string_at(const json::value& value, const char* pointer) {
  return std::string{value.at_pointer(pointer).as_string()};
}

struct CampaignServiceTest : CellTest {
  CampaignServiceTest() {
    config.campaign.remeasure = false;
    load();
  }
  Wait campaign(std::string method, json::object params = {}) {
    const Answer started = co_await ask(std::move(method), std::move(params));
    EXPECT_TRUE(started) << started.error().message;
    co_await campaign_ended();
  }
  /// Runs a whole campaign. @return what campaign.get then says of it
  json::value ended(std::string method, json::object params = {}) {
    play([&]() -> Wait { co_await campaign(std::move(method), std::move(params)); });
    return call("campaign.get", {{"points_limit", 100}}).value();
  }
  /// Stops the daemon in the middle of a campaign. @return its id
  std::string interrupted(json::object params = {}) {
    play([&]() -> Wait {
      const Answer started = co_await ask("campaign.start", params);
      EXPECT_TRUE(started) << started.error().message;
      while (told(control::Topic::Measurement).size() < 7) co_await pass(1s);
      co_await cell.shut_down();
      // The daemon that comes after finds the devices disconnected and has no fault.
      co_await pass(10s);
      co_await ask("cell.acknowledge");
    });
    return store->last_campaign().value()->id;
  }
  std::vector<std::string> phases() {
    std::vector<std::string> names;
    for (const json::value& progress : told(control::Topic::Campaign)) {
      const std::string phase = string_at(progress, "/phase");
      if (names.empty() || names.back() != phase) names.push_back(phase);
    }
    return names;
  }
};

TEST_F(CampaignServiceTest, CalibratesActivatesTheModelAndTellsEachStep) {
  const json::value campaign = ended("campaign.start");
  EXPECT_EQ(campaign.at_pointer("/campaign/state"), "done");
  EXPECT_EQ(campaign.at("points").as_array().size(), 28U);
  EXPECT_TRUE(campaign.at("progress").is_null());
  EXPECT_THAT(phases(), testing::ElementsAre("connecting", "computing", "warming_up", "identifying",
                                             "validating", "computing", "activating", "done"));
  EXPECT_EQ(told(control::Topic::Measurement).size(), 28U);
  const auto changes = told(control::Topic::Model);
  ASSERT_THAT(changes, SizeIs(2));
  EXPECT_EQ(changes[0].at("change"), "made");
  EXPECT_EQ(changes[1].at("change"), "activated");
  const json::value now = status();
  EXPECT_EQ(now.at("state"), "ready");
  EXPECT_EQ(now.at_pointer("/model/id"), campaign.at_pointer("/campaign/model_id"));
  EXPECT_EQ(now.at_pointer("/robot/serial"), "MOCK-0001") << "which the campaign has connected";
}

TEST_F(CampaignServiceTest, KeepsTheModelInForceWhereTheNewOneIsNotToBeActivated) {
  const json::value campaign = ended("campaign.start", {{"activate", false}});
  EXPECT_EQ(status().at_pointer("/model/id"), "m1");
  EXPECT_FALSE(campaign.at_pointer("/campaign/model_id").is_null());
}

TEST_F(CampaignServiceTest, RefusesACampaignOfTooFewPosesBeforeTheArmMoves) {
  EXPECT_EQ(
      refused("campaign.start", {{"identify_poses", 8}}),
      "params.identify_poses: 8 are too few for the parameters of this arm: give at least 10, better twice "
      "as many");
  EXPECT_EQ(refused("campaign.start", {{"kind", "dance"}}),
            "params.kind: expected calibration, targets, iso9283, tool or base");
  EXPECT_EQ(status().at("state"), "disconnected");
}

TEST_F(CampaignServiceTest, RefusesWhatWouldDisturbTheCampaignThatIsUnderWay) {
  play([this]() -> Wait {
    co_await ask("campaign.start");
    co_await pass(1min);
    for (const char* method : {"campaign.start", "drift.check", "stream.start", "cell.disconnect"}) {
      const Answer answer = co_await ask(method);
      EXPECT_EQ(answer.error().code, control::ErrorCode::WrongState) << method;
      EXPECT_THAT(answer.error().message,
                  HasSubstr("state campaign; allowed: campaign.pause, campaign.abort"));
    }
    co_await ask("campaign.abort");
  });
}

TEST_F(CampaignServiceTest, StandsStillWhileItIsPausedAndGoesOn) {
  play([this]() -> Wait {
    co_await ask("campaign.start");
    co_await pass(1min);
    Answer answer = co_await ask("campaign.pause");
    EXPECT_EQ(answer->at("phase"), "paused");
    co_await pass(1min);
    const JointVector stands = mock.q();
    co_await pass(1h);
    EXPECT_EQ(mock.q(), stands);
    answer = co_await ask("cell.status");
    EXPECT_EQ(answer->at("state"), "paused");
    answer = co_await ask("campaign.resume");
    EXPECT_EQ(answer->at("phase"), "identifying");
    co_await campaign_ended();
  });
  EXPECT_EQ(call("campaign.get")->at_pointer("/campaign/state"), "done");
}

TEST_F(CampaignServiceTest, SaysWhyItIsPausedWhereNobodyIsInCommandAnyMore) {
  play([&]() -> Wait {
    const Answer started = co_await ask("campaign.start");
    EXPECT_TRUE(started) << started.error().message;
    while (told(control::Topic::Measurement).empty()) co_await pass(1s);
    auto pausing = cell.pause("Anna no longer renews its control", "trueposed");
    const Answer paused = co_await std::move(pausing);
    EXPECT_TRUE(paused) << paused.error().message;
    const Answer now = co_await ask("cell.status");
    EXPECT_EQ(now->at("state"), "paused");
    EXPECT_EQ(now->at("state_text"),
              "paused, since Anna no longer renews its control: resume the campaign or abort it");
    EXPECT_EQ(told(control::Topic::Cell).back().at("by"), "trueposed");
    const Answer aborted = co_await ask("campaign.abort");
    EXPECT_TRUE(aborted) << aborted.error().message;
  });
}

TEST_F(CampaignServiceTest, KeepsWhoStartedACampaignAndWhatFor) {
  play([this]() -> Wait {
    const json::object order{{"note", "after the new gripper"}};
    co_await ask("campaign.start", order);
    co_await campaign_ended();
  });
  const json::value found = *call("campaign.get");
  EXPECT_EQ(found.at_pointer("/campaign/by"), kOperator);
  EXPECT_EQ(found.at_pointer("/campaign/note"), "after the new gripper");
  EXPECT_EQ(call("campaign.list")->at_pointer("/campaigns/0/by"), kOperator);
  const std::string told_of = call("report.get")->at_pointer("/document/campaign").as_string().c_str();
  EXPECT_THAT(told_of, testing::EndsWith(", started by Anna: after the new gripper"));
  EXPECT_EQ(told(control::Topic::Cell).front().at("by"), kOperator);
  EXPECT_TRUE(told(control::Topic::Cell).back().at("by").is_null()) << "it ended by itself";
}

TEST_F(CampaignServiceTest, GivesItsPointsInPartsThatFitIntoALine) {
  play([this]() -> Wait {
    co_await ask("campaign.start");
    co_await campaign_ended();
  });
  for (const char* format : {"json", "csv"}) {
    SCOPED_TRACE(format);
    std::string csv;
    std::size_t points = 0;
    std::int64_t total = 0;
    for (json::value next = 0; !next.is_null();) {
      const Answer answer = call("campaign.points", {{"format", format}, {"offset", next}, {"limit", 7}});
      ASSERT_TRUE(answer) << answer.error().message;
      const json::value& page = *answer;
      EXPECT_LT(control::json_text(page).size(), std::size_t{64} * 1024);
      if (const json::value* lines = page.as_object().if_contains("csv")) csv += lines->as_string();
      if (const json::value* list = page.as_object().if_contains("points")) points += list->as_array().size();
      total = page.at("total").to_number<std::int64_t>();
      next = page.at("next");
    }
    if (csv.empty()) {
      EXPECT_EQ(points, static_cast<std::size_t>(total));
      EXPECT_EQ(total, call("campaign.get")->at("points_total").to_number<std::int64_t>());
    } else {
      EXPECT_EQ(std::ranges::count(csv, '\n'), total + 1) << "with the header";
      EXPECT_THAT(csv, testing::StartsWith("q1,q2,q3,q4,q5,q6,x,y,z,smr,set"));
    }
  }
}

TEST_F(CampaignServiceTest, GivesThePageOfItsReportInParts) {
  play([this]() -> Wait {
    co_await ask("campaign.start");
    co_await campaign_ended();
  });
  std::string html;
  std::uint64_t bytes = 0;
  for (json::value next = 0; !next.is_null();) {
    const Answer part = call("report.html", {{"offset", next}});
    ASSERT_TRUE(part) << part.error().message;
    EXPECT_LT(control::json_text(*part).size(), std::size_t{64} * 1024);
    html += part->at("html").as_string();
    bytes = part->at("bytes").to_number<std::uint64_t>();
    next = part->at("next");
  }
  EXPECT_EQ(html.size(), bytes);
  EXPECT_THAT(html, testing::StartsWith("<!DOCTYPE html>"));
  EXPECT_THAT(html, testing::EndsWith("</html>\n"));
  EXPECT_THAT(html, testing::HasSubstr("started by Anna"));
  EXPECT_THAT(refused("report.html", {{"id", "no such"}}), testing::HasSubstr("no such campaign"));
}

TEST_F(CampaignServiceTest, AnAbortIsAnsweredOnceTheArmStands) {
  play([this]() -> Wait {
    co_await ask("campaign.start");
    co_await pass(63s);
    const TimePoint asked = clock.now();
    Answer answer = co_await ask("campaign.abort");
    EXPECT_EQ(answer->at("phase"), "aborted");
    EXPECT_EQ(answer->at("reason"), "aborted by an operator");
    EXPECT_FALSE(mock.moving());
    EXPECT_LT(clock.now() - asked, 1s);
    answer = co_await ask("cell.status");
    EXPECT_EQ(answer->at("state"), "ready");
    EXPECT_TRUE(answer->at("campaign").is_null());
  });
}

TEST_F(CampaignServiceTest, AnAbortBeforeTheTrackerIsConnectedIsNoFault) {
  play([this]() -> Wait {
    co_await ask("campaign.start");
    co_await pass(1s);
    EXPECT_TRUE(robot.connected());
    EXPECT_EQ((co_await ask("cell.status"))->at_pointer("/tracker/connected"), false);
    const Answer aborted = co_await ask("campaign.abort");
    EXPECT_EQ(aborted->at("phase"), "aborted");
    co_await pass(1min);
    const Answer now = co_await ask("cell.status");
    EXPECT_EQ(now->at("state"), "disconnected");
    EXPECT_EQ(fault_of(*now), "");
    EXPECT_FALSE(robot.connected());
  });
}

TEST_F(CampaignServiceTest, IsDoneForNobodyBeforeItsModelIsInForce) {
  bool ran = false;
  store_thread.after_each_job = [&] {
    const DaemonCell::Snapshot now = cell.snapshot();
    ran = ran || now.campaign;
    if (ran && !now.campaign) {
      EXPECT_NE(now.model->id, "m1");
    }
  };
  play([this]() -> Wait { co_await campaign("campaign.start"); });
  EXPECT_TRUE(ran);
  EXPECT_NE(status().at_pointer("/model/id"), "m1");
}

TEST_F(CampaignServiceTest, TellsNoTimeThatIsLeftOfOneThatWasAborted) {
  play([this]() -> Wait {
    co_await ask("campaign.start");
    co_await pass(2min);
    const Answer now = co_await ask("cell.status");
    EXPECT_FALSE(now->at_pointer("/campaign/eta_s").is_null());
    const Answer aborted = co_await ask("campaign.abort");
    EXPECT_EQ(string_at(*aborted, "/phase"), "aborted");
    EXPECT_TRUE(aborted->at("eta_s").is_null());
  });
}

TEST_F(CampaignServiceTest, TheDaemonThatIsStoppedInterruptsTheCampaignFirst) {
  play([this]() -> Wait {
    co_await ask("campaign.start");
    co_await pass(1min);
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

TEST_F(CampaignServiceTest, GoesOnWithACampaignThatWasInterruptedAndSaysSo) {
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
                    HasSubstr("give its id to go on with it")));

  const std::size_t told_before = told(control::Topic::Measurement).size();
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
  EXPECT_EQ(told(control::Topic::Measurement).size(), told_before + 28 - static_cast<std::size_t>(done));
  EXPECT_THAT(string_at(campaign, "/interruptions/0/found"), HasSubstr("nothing has moved"));
  EXPECT_EQ(status().at_pointer("/model/id"), campaign.at_pointer("/campaign/model_id"));
  EXPECT_TRUE(status().at("interrupted").as_array().empty());
  const json::value report = call("report.get", {{"id", id}}).value();
  EXPECT_THAT(string_at(report, "/document/interruptions/0/found"), HasSubstr("nothing has moved"));
  EXPECT_EQ(refused("campaign.resume", {{"id", id}}), "no campaign " + id + " was interrupted");
}

TEST_F(CampaignServiceTest, GoesOnWithWhatItWasOrderedToDo) {
  const std::string id =
      interrupted({{"identify_poses", 12}, {"validate_poses", 3}, {"activate", false}, {"remeasure", true}});
  config.campaign.identify_poses = 40;  // in the cell file, meanwhile
  play([this, id]() -> Wait {
    const json::object which{{"id", id}};
    co_await ask("campaign.resume", which);
    co_await campaign_ended();
  });
  const json::value campaign = call("campaign.get").value();
  EXPECT_EQ(campaign.at_pointer("/campaign/state"), "done");
  const auto skipped = static_cast<std::int64_t>(campaign.at("skipped").as_array().size());
  EXPECT_EQ(campaign.at("points_total").to_number<std::int64_t>() + skipped, 12 + 3 + 3 + 2)
      << "two were measured again";
  EXPECT_EQ(status().at_pointer("/model/id"), "m1");
}

TEST_F(CampaignServiceTest, EndsACampaignThatWasInterruptedWhereNobodyWantsIt) {
  const std::string id = interrupted();
  const json::value aborted = call("campaign.abort", {{"id", id}}).value();
  EXPECT_EQ(aborted.at("phase"), "aborted");
  EXPECT_EQ(string_at(aborted, "/id"), id);
  EXPECT_EQ(store->campaign(id).value()->state, "aborted");
  EXPECT_TRUE(status().at("interrupted").as_array().empty());
  EXPECT_EQ(phases().back(), "aborted");
  EXPECT_EQ(refused("campaign.abort", {{"id", id}}), "no campaign " + id + " was interrupted");
}

TEST_F(CampaignServiceTest, StaysInterruptedAndSaysWhyWhereItCannotGoOn) {
  const std::string id = interrupted();
  execute("UPDATE campaign SET robot_serial='4711' WHERE state='interrupted'");
  play([this, id]() -> Wait {
    const json::object which{{"id", id}};
    co_await ask("campaign.resume", which);
    co_await campaign_ended();
  });
  const json::value campaign = call("campaign.get", {{"id", id}}).value();
  EXPECT_EQ(campaign.at_pointer("/campaign/state"), "interrupted");
  EXPECT_THAT(string_at(campaign, "/campaign/reason"), HasSubstr("it did not go on: another arm"));
  EXPECT_THAT(fault(), HasSubstr("another arm"));
  EXPECT_EQ(string_at(status(), "/interrupted/0/id"), id);
}

TEST_F(CampaignServiceTest, RefusesToGoOnWhereThePlanNoLongerFitsTheCellFile) {
  const std::string id = interrupted();
  config.workspace.max_mm.z() = 900;
  EXPECT_THAT(refused("campaign.resume", {{"id", id}}), AllOf(HasSubstr("cannot go on in this cell: pose "),
                                                              HasSubstr("set that right in the cell file")));
  EXPECT_EQ(status().at("state"), "disconnected");
  EXPECT_EQ(string_at(status(), "/interrupted/0/id"), id);
}

TEST_F(CampaignServiceTest, KnowsAfterAKillWhatWasUnderWay) {
  const std::string id = interrupted();
  // As a daemon that was killed has left it.
  execute("UPDATE campaign SET state='running', ended='', reason='' WHERE state='interrupted'");
  EXPECT_EQ(store->plans().interrupt_running("2026-02-03T08:00:00Z").value(), 1);
  EXPECT_TRUE(finish(cell.load_interrupted_campaigns()));
  EXPECT_EQ(status().at_pointer("/interrupted/0/reason"), "the daemon ended in the middle of it");
  play([this, id]() -> Wait {
    const json::object which{{"id", id}};
    co_await ask("campaign.resume", which);
    co_await campaign_ended();
  });
  EXPECT_EQ(store->campaign(id).value()->state, "done");
}

TEST_F(CampaignServiceTest, ADriftCheckIsNotInterruptedButAborted) {
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

TEST_F(CampaignServiceTest, SaysWhichDeviceItWaitsForUntilThatAnswersAgain) {
  play([this]() -> Wait {
    co_await ask("campaign.start");
    co_await pass(1min);
    robot.disconnect();
    robot.leave(20s);
    co_await pass(15s);
    Answer now = co_await ask("cell.status");
    EXPECT_EQ(now->at("state"), "campaign");
    EXPECT_EQ(now->at_pointer("/waiting/device"), "controller") << control::json_text(*now);
    EXPECT_THAT(string_at(*now, "/waiting/reason"), HasSubstr("robot: the controller does not answer"));
    co_await pass(1min);
    now = co_await ask("cell.status");
    EXPECT_TRUE(now->at("waiting").is_null());
    co_await ask("campaign.abort");
  });
}

TEST_F(CampaignServiceTest, PausesWhereADeviceStaysAwayAndGoesOnByItselfOnceItIsBack) {
  play([this]() -> Wait {
    co_await ask("campaign.start");
    co_await pass(1min);
    robot.disconnect();
    robot.leave(10min);
    co_await pass(40s);
    Answer now = co_await ask("cell.status");
    EXPECT_EQ(now->at("state"), "campaign");
    EXPECT_EQ(now->at_pointer("/robot/connected"), false);
    EXPECT_EQ(now->at_pointer("/tracker/connected"), true);
    EXPECT_THAT(string_at(*now, "/state_text"), HasSubstr("waiting for the controller, 3"));
    EXPECT_TRUE(now->at_pointer("/campaign/eta_s").is_null());
    co_await pass(100s);
    now = co_await ask("cell.status");
    EXPECT_EQ(now->at("state"), "paused");
    EXPECT_THAT(string_at(*now, "/state_text"),
                AllOf(HasSubstr("robot: the controller does not answer"), HasSubstr("goes on by itself")));
    co_await pass(9min);
    now = co_await ask("cell.status");
    EXPECT_EQ(now->at("state"), "campaign");
    EXPECT_EQ(now->at_pointer("/robot/connected"), true);
    EXPECT_FALSE(now->at_pointer("/campaign/eta_s").is_null());
    co_await campaign_ended();
  });
  EXPECT_EQ(call("campaign.get")->at_pointer("/campaign/state"), "done");
  EXPECT_EQ(call("campaign.get")->at("points").as_array().size(), 0U);
  EXPECT_EQ(call("campaign.get")->at("points_total"), 28);
}

TEST_F(CampaignServiceTest, TellsAnEmergencyStopWhileTheArmIsOnItsWay) {
  play([this]() -> Wait {
    co_await ask("campaign.start");
    while (!mock.moving()) co_await pass(100ms);
    robot.press_emergency_stop(true);
    co_await pass(2s);
    Answer now = co_await ask("cell.status");
    EXPECT_EQ(now->at_pointer("/waiting/reason"), "robot: emergency stop") << control::json_text(*now);
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

TEST_F(CampaignServiceTest, NoticesATrackerThatIsLostWhileItIsPaused) {
  play([this]() -> Wait {
    co_await ask("campaign.start");
    co_await pass(1min);
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

TEST_F(CampaignServiceTest, SaysWhichDevicesAreConnectedFromTheFirstOnes) {
  play([this]() -> Wait {
    co_await ask("campaign.start");
    co_await pass(1s);
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

TEST_F(CampaignServiceTest, AStoreThatFailsIsAFaultUntilItIsAcknowledged) {
  play([this]() -> Wait {
    co_await ask("campaign.start");
    co_await pass(1min);
    execute("DROP TABLE point");
    co_await campaign_ended();
  });
  EXPECT_EQ(status().at("state"), "fault");
  EXPECT_THAT(fault(), AllOf(HasSubstr("store: "), HasSubstr("no such table")));
  EXPECT_EQ(call("cell.acknowledge")->at("state"), "disconnected");
}

TEST_F(CampaignServiceTest, PausesItselfWhereSomebodyStandsInTheBeam) {
  play([this]() -> Wait {
    co_await ask("campaign.start");
    co_await pass(1min);
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

TEST_F(CampaignServiceTest, ChecksTheActiveModelForDriftAndReportsTheCalibrationStill) {
  const json::value report = call("report.get")->at("id");
  const json::value campaign = ended("drift.check", {{"poses", 6}});
  EXPECT_EQ(campaign.at_pointer("/campaign/kind"), "drift");
  EXPECT_EQ(campaign.at_pointer("/drift/points").as_array().size(), 6U);
  EXPECT_NE(campaign.at_pointer("/drift/verdict"), "failed") << control::json_text(campaign.at("drift"));
  EXPECT_EQ(call("report.get")->at("id"), report) << "a drift check is no calibration to report";
  EXPECT_THAT(refused("report.get", {{"id", campaign.at_pointer("/campaign/id")}}),
              HasSubstr("has no report"));
}

TEST_F(CampaignServiceTest, UpdatesAModelAfterTheTrackerWasMovedAndTakesTheOldOneBack) {
  mock.bump_tracker({0.4, -0.5, 0.3});
  EXPECT_EQ(ended("drift.check").at_pointer("/drift/verdict"), "failed");

  const json::value campaign = ended("drift.check", {{"update", true}});
  EXPECT_EQ(campaign.at_pointer("/drift/update/offered"), true) << control::json_text(campaign.at("drift"));
  EXPECT_THAT(campaign.at_pointer("/drift/update/moved/0").as_string().c_str(),
              HasSubstr("the tracker or the base moved"));
  const json::value id = campaign.at_pointer("/campaign/model_id");
  EXPECT_THAT(std::string{call("model.export", {{"id", id}})->at("yaml").as_string()},
              HasSubstr("\nupdates: \"m1\"\n"));
  EXPECT_EQ(call("model.get")->at_pointer("/model/id"), "m1")
      << "a new model waits for somebody who wants it";

  EXPECT_TRUE(call("model.activate", {{"id", id}})->at("active").as_bool());
  EXPECT_NE(ended("drift.check").at_pointer("/drift/verdict"), "failed");
  mock.bump_tracker({-0.4, 0.5, -0.3});
  EXPECT_TRUE(call("model.activate", {{"id", "m1"}})->at("active").as_bool());
  EXPECT_NE(ended("drift.check").at_pointer("/drift/verdict"), "failed");
}

TEST_F(CampaignServiceTest, ActivatesAnUpdatedModelOnlyWhereThatIsAskedFor) {
  EXPECT_THAT(refused("drift.check", {{"activate", true}}), HasSubstr("give update too"));
  const json::value unchanged = ended("drift.check", {{"update", true}, {"activate", true}});
  EXPECT_EQ(unchanged.at_pointer("/drift/update/offered"), false);
  EXPECT_TRUE(unchanged.at_pointer("/campaign/model_id").is_null());
  mock.bump_tracker({0.4, -0.5, 0.3});
  const json::value campaign = ended("drift.check", {{"update", true}, {"activate", true}});
  EXPECT_EQ(call("model.get")->at_pointer("/model/id"), campaign.at_pointer("/campaign/model_id"));
}

TEST_F(CampaignServiceTest, FindsTheJointsOfTargetsThatAreGivenAsJointsOrPosesOrNotAtAll) {
  ended("campaign.start", {{"identify_poses", 30}});
  const json::array joints(1, {-5, -75, 100, 5, -60, 10});
  for (const json::object& given : {json::object{{"joints", joints}}, json::object{{"validate_poses", 1}}}) {
    json::object params = given;
    params["kind"] = "targets";
    params["rounds"] = 3;
    params["tolerance_mm"] = 1;
    params["readings"] = 1;
    const json::value campaign = ended("campaign.start", params);
    EXPECT_EQ(campaign.at_pointer("/campaign/kind"), "targets");
    EXPECT_TRUE(campaign.at("targets").is_null()) << "beside the points it is too long for a line";
    EXPECT_EQ(call("campaign.get")->at_pointer("/targets/targets").as_array().size(), 1U);
  }
  EXPECT_THAT(
      refused("campaign.start", {{"kind", "targets"}, {"poses", json::array(1, {9000, 0, 0, 0, 0, 0})}}),
      "params.poses[0]: cannot be reached");
  EXPECT_THAT(refused("campaign.start", {{"kind", "targets"}, {"joints", joints}, {"poses", joints}}),
              HasSubstr("not both"));
}

TEST_F(CampaignServiceTest, MeasuresCyclesOfATestWithAndWithoutTheModel) {
  const json::value with = ended("campaign.start", {{"kind", "iso9283"}, {"cycles", 2}});
  EXPECT_EQ(with.at("points").as_array().size(), 10U);
  EXPECT_EQ(call("campaign.get")->at_pointer("/iso9283/compensated"), true);
  ASSERT_TRUE(call("model.deactivate"));
  EXPECT_THAT(refused("campaign.start", {{"kind", "iso9283"}}), HasSubstr("no model is active"));
  ended("campaign.start", {{"kind", "iso9283"}, {"cycles", 2}, {"compensate", false}});
  EXPECT_EQ(call("campaign.get")->at_pointer("/iso9283/compensated"), false);
}

/// What goes wrong, and whom the log blames.
struct Trouble {
  const char* kind;
  double drivers::MockFaults::*probability;
  const char* blamed;
};

void PrintTo(const Trouble& trouble, std::ostream* out) { *out << trouble.kind; }

struct ACampaignInTrouble : CampaignServiceTest, testing::WithParamInterface<Trouble> {};

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

struct CampaignArchiveTest : CellTest {};

TEST_F(CampaignArchiveTest, ListsCampaignsTheLastOneFirstAPageAtATime) {
  const json::value all = call("campaign.list").value();
  EXPECT_EQ(all.at("total"), 2);
  EXPECT_EQ(all.at_pointer("/campaigns/0/id"), "c1");
  const json::value second = call("campaign.list", {{"offset", 1}, {"limit", 5}}).value();
  EXPECT_THAT(second.at("campaigns").as_array(), SizeIs(1));
  EXPECT_EQ(second.at_pointer("/campaigns/0/id"), "c2");
}

TEST_F(CampaignArchiveTest, GivesTheLastCampaignOrTheOneThatIsNamedWithAPageOfItsPoints) {
  EXPECT_EQ(call("campaign.get")->at_pointer("/campaign/id"), "c1");
  const json::value named =
      call("campaign.get", {{"id", "c2"}, {"points_offset", 20}, {"points_limit", 100}}).value();
  EXPECT_EQ(named.at_pointer("/campaign/id"), "c2");
  EXPECT_EQ(named.at("points_total"), 28);
  EXPECT_EQ(named.at("points").as_array().size(), 8U);
  EXPECT_EQ(named.at_pointer("/points/0/pose"), 21);
  EXPECT_EQ(named.at_pointer("/points/0/purpose"), "validate");
  EXPECT_EQ(refused("campaign.get", {{"id", "c3"}}), "no such campaign");
  EXPECT_THAT(refused("campaign.get", {{"points_limit", 101}}), HasSubstr("points_limit"));
}

TEST_F(CampaignArchiveTest, GivesTheCampaignThatIsUnderWayAlsoBeforeTheStoreHasIt) {
  play([this]() -> Wait {
    const Answer started = co_await ask("campaign.start");
    for (const drivers::Duration time : {100ms, 100'000ms}) {
      co_await pass(time);
      const Answer found = co_await ask("campaign.get");
      EXPECT_EQ(found->at_pointer("/campaign/id"), started->at("id"));
      EXPECT_EQ(found->at_pointer("/progress/id"), started->at("id"));
      EXPECT_EQ(found->at_pointer("/campaign/state"), "running");
    }
    co_await ask("campaign.abort");
  });
}

TEST_F(CampaignArchiveTest, ReportsTheLastCalibrationOrTheOneThatIsNamed) {
  EXPECT_EQ(call("report.get")->at("id"), "c1");
  const json::value report =
      call("report.get", {{"id", "c2"}, {"points_offset", 4}, {"points_limit", 10}}).value();
  EXPECT_EQ(report.at("points_total"), 28);
  EXPECT_EQ(report.at_pointer("/document/points").as_array().size(), 10U);
  EXPECT_EQ(report.at_pointer("/document/points/0/pose"), 5);
  EXPECT_EQ(refused("report.get", {{"id", "c3"}}), "no such campaign, or it has no report");
  execute("UPDATE campaign SET document='{' WHERE id='c2'");
  EXPECT_THAT(refused("report.get", {{"id", "c2"}}), testing::StartsWith("the stored document: "));
  execute("UPDATE campaign SET state='failed'");
  EXPECT_EQ(refused("report.get"), "no such campaign, or it has no report");
}

TEST_F(CampaignArchiveTest, SaysOfAStoreThatCannotBeReadWhatIsWrongWithIt) {
  for (const char* table : {"skipped", "point", "campaign"}) {
    execute(std::string{"DROP TABLE "} + table);
    EXPECT_THAT(refused("campaign.get"), HasSubstr("no such table"));
  }
  for (const char* method : {"campaign.list", "report.get"})
    EXPECT_THAT(refused(method), HasSubstr("no such table"));
}

}  // namespace
}  // namespace truepose::daemon
