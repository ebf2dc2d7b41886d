#include "daemon/cell/campaign_service.hpp"

#include <algorithm>

#include "tests/daemon/campaign_service_fixture.hpp"
#include "tests/trials.hpp"

namespace truepose::daemon {
namespace {

namespace json = boost::json;
using namespace std::chrono_literals;
using testing::HasSubstr;
using testing::SizeIs;

TEST_F(CampaignServiceTest, CalibratesActivatesTheModelAndTellsEachStep) {
  const json::value campaign = ended("campaign.start");
  EXPECT_EQ(campaign.at_pointer("/campaign/state"), "done");
  EXPECT_EQ(campaign.at("points").as_array().size(), 28U);
  EXPECT_TRUE(campaign.at("progress").is_null());
  EXPECT_THAT(phases(), testing::ElementsAre("connecting", "computing", "warming_up", "identifying",
                                             "validating", "computing", "activating", "done"));
  EXPECT_EQ(event_data(control::Topic::Measurement).size(), 28U);
  const auto changes = event_data(control::Topic::Model);
  ASSERT_THAT(changes, SizeIs(2));
  EXPECT_EQ(changes[0].at("change"), "made");
  EXPECT_EQ(changes[1].at("change"), "activated");
  const json::value now = status();
  EXPECT_EQ(now.at("state"), "ready");
  EXPECT_EQ(now.at_pointer("/model/id"), campaign.at_pointer("/campaign/model_id"));
  EXPECT_EQ(now.at_pointer("/robot/serial"), "MOCK-0001") << "which the campaign has connected";
}

/// At whatever moment between two questions: one that is under way gets its answer before the campaign
/// connects.
TEST_F(CampaignServiceTest, WaitsForNoControllerThatAnswersTheQuestionsOfAReadyCell) {
  play([this]() -> Wait {
    co_await connected();
    for (drivers::Duration after = 0ms; after < 1s; after += 10ms) {
      co_await pass(1s + after);
      send("campaign.start");
      co_await pass(2s);
      co_await ask("campaign.abort");
      co_await pass(1min);
    }
  });
  for (const json::value& event : event_data(control::Topic::Cell))
    EXPECT_THAT(control::json_text(event), testing::Not(HasSubstr("cut off")));
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
            "params.kind: expected one of calibration, targets, iso9283, tool, base, found \"dance\"");
  EXPECT_EQ(status().at("state"), "disconnected");
}

TEST_F(CampaignServiceTest, RefusesWhatWouldDisturbTheCampaignThatIsUnderWay) {
  play([this]() -> Wait {
    co_await under_way();
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
    co_await under_way();
    Answer answer = co_await ask("campaign.pause");
    EXPECT_EQ(answer->at("phase"), "paused");
    co_await pass(1min);
    const JointVector stands = mock.q();
    co_await pass(all_trials() ? 1h : 10min);
    EXPECT_EQ(mock.q(), stands);
    answer = co_await ask("cell.status");
    EXPECT_EQ(answer->at("state"), "paused");
    answer = co_await ask("campaign.resume");
    EXPECT_EQ(answer->at("phase"), "identifying");
    co_await campaign_ended();
  });
  EXPECT_EQ(call("campaign.get")->at_pointer("/campaign/state"), "done");
}

TEST_F(CampaignServiceTest, PausesWhereThereIsNoMemoryToComputeAndGoesOnOnceThereIs) {
  load();
  bool no_memory = true;
  compute_thread.before_each_job = [&] {
    if (no_memory) throw std::bad_alloc{};
  };
  play([&]() -> Wait {
    EXPECT_TRUE(co_await ask("campaign.start"));
    Answer now = co_await ask("cell.status");
    for (; now->at("state") != "paused"; now = co_await ask("cell.status")) co_await pass(1s);
    EXPECT_THAT(now->at("state_text").as_string().c_str(), HasSubstr("the PC has no memory"));
    EXPECT_TRUE(co_await ask("campaign.resume"));
    co_await pass(1s);
    EXPECT_EQ((co_await ask("cell.status"))->at("state"), "paused") << "there still is none";
    no_memory = false;
    EXPECT_TRUE(co_await ask("campaign.resume"));
    co_await campaign_ended();
  });
  EXPECT_EQ(call("campaign.get")->at_pointer("/campaign/state"), "done");
}

TEST_F(CampaignServiceTest, SaysWhyItIsPausedWhereNobodyIsInCommandAnyMore) {
  play([&]() -> Wait {
    const Answer started = co_await ask("campaign.start");
    EXPECT_TRUE(started) << started.error().message;
    while (event_data(control::Topic::Measurement).empty()) co_await pass(1s);
    auto pausing = cell.pause("Anna has not renewed its control", "trueposed");
    const Answer paused = co_await std::move(pausing);
    EXPECT_TRUE(paused) << paused.error().message;
    const Answer now = co_await ask("cell.status");
    EXPECT_EQ(now->at("state"), "paused");
    EXPECT_EQ(now->at("state_text"),
              "paused, since Anna has not renewed its control: resume the campaign or abort it");
    EXPECT_EQ(event_data(control::Topic::Cell).back().at("by"), "trueposed");
    const Answer aborted = co_await ask("campaign.abort");
    EXPECT_TRUE(aborted) << aborted.error().message;
  });
}

TEST_F(CampaignServiceTest, KeepsWhoStartedACampaignAndWhatFor) {
  const json::value found = ended("campaign.start", {{"note", "after the new gripper"}});
  EXPECT_EQ(found.at_pointer("/campaign/by"), kOperator);
  EXPECT_EQ(found.at_pointer("/campaign/note"), "after the new gripper");
  EXPECT_EQ(call("campaign.list")->at_pointer("/campaigns/0/by"), kOperator);
  const std::string campaign_text = call("report.get")->at_pointer("/document/campaign").as_string().c_str();
  EXPECT_THAT(campaign_text, testing::EndsWith(", started by Anna: after the new gripper"));
  EXPECT_EQ(event_data(control::Topic::Cell).front().at("by"), kOperator);
  EXPECT_TRUE(event_data(control::Topic::Cell).back().at("by").is_null()) << "it ended by itself";
}

TEST_F(CampaignServiceTest, GivesItsPointsInPartsThatFitIntoALine) {
  ended("campaign.start");
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
  ended("campaign.start");
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

TEST_F(CampaignServiceTest, GivesThePageThatWasBegunWithoutAnIdToItsEndThoughACampaignEndsMeanwhile) {
  ended("campaign.start");
  const json::value first = call("report.html").value();
  set_ahead = std::chrono::seconds{60};
  const auto next = [&] { return call("report.html", {{"offset", first.at("next")}}).value(); };
  EXPECT_EQ(next().at("made"), first.at("made")) << "made again for its second part";
  ended("campaign.start");
  EXPECT_EQ(next().at("id"), first.at("id"));
  EXPECT_EQ(next().at("made"), first.at("made"));
  EXPECT_NE(call("report.html")->at("id"), first.at("id"));
}

TEST_F(CampaignServiceTest, AnAbortBeforeTheTrackerIsConnectedIsNoFault) {
  play([this]() -> Wait {
    co_await under_way(1s);
    EXPECT_TRUE(robot.connected());
    EXPECT_EQ((co_await ask("cell.status"))->at_pointer("/tracker/connected"), false);
    const Answer aborted = co_await ask("campaign.abort");
    EXPECT_EQ(aborted->at("phase"), "aborted");
    Answer now = co_await ask("cell.status");
    EXPECT_EQ(now->at("state"), "ready") << "it was connected all the same";
    EXPECT_TRUE(co_await ask("cell.disconnect"));
    co_await under_way(1s);
    tracker.leave(1h);
    co_await ask("campaign.abort");
    co_await pass(1min);
    now = co_await ask("cell.status");
    EXPECT_EQ(now->at("state"), "disconnected") << "where that cannot be";
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
    co_await under_way(2min);
    const Answer now = co_await ask("cell.status");
    EXPECT_FALSE(now->at_pointer("/campaign/eta_s").is_null());
    const Answer aborted = co_await ask("campaign.abort");
    EXPECT_EQ(string_at(*aborted, "/phase"), "aborted");
    EXPECT_EQ(string_at(*aborted, "/reason"), "aborted by an operator");
    EXPECT_TRUE(aborted->at("eta_s").is_null());
  });
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
    EXPECT_TRUE(campaign.at("targets").is_null()) << "with the points it is too long for a line";
    EXPECT_EQ(call("campaign.get")->at_pointer("/targets/targets").as_array().size(), 1U);
  }
  EXPECT_THAT(
      refused("campaign.start", {{"kind", "targets"}, {"poses", json::array(1, {9000, 0, 0, 0, 0, 0})}}),
      HasSubstr("params.poses[0]: cannot be reached: the pose is out of the arm's reach"));
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

}  // namespace
}  // namespace truepose::daemon
