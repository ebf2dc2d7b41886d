// Work frames whose points the arm's TCP touches, as the daemon is asked for them.
#include <boost/json/value_to.hpp>

#include "config/frame_file.hpp"
#include "config/model_file.hpp"
#include "core/math/angles.hpp"
#include "proto/record/frame_document.hpp"
#include "tests/daemon/cell_fixture.hpp"
#include "tests/daemon/jogging_hand.hpp"

namespace truepose::daemon {
namespace {

namespace json = boost::json;
using namespace std::chrono_literals;
using testing::AllOf;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;
using testing::StartsWith;

struct TouchedBaseServiceTest : CellTest {
  TouchedBaseServiceTest() { load(); }
  /// Measures tool 3 by the tracker and takes it into use.
  void have_tool() {
    play([&]() -> Wait {
      mock.put_reflector(kTcp_mm);
      json::object params{{"kind", "tool"}, {"number", 3}};
      const Answer started = co_await ask("campaign.start", params);
      EXPECT_TRUE(started) << started.error().message;
      co_await campaign_ended();
      json::object id{{"id", store->last_campaign().value()->id}};
      const Answer used = co_await ask("tool.activate", id);
      EXPECT_TRUE(used) << used.error().message;
    });
  }
  static json::object base_order() {
    return {{"kind", "base"}, {"number", 5}, {"touch", 3}, {"points", {"origin", "x", "xy"}}};
  }
  Wait until_state(std::string state) {
    for (int seconds = 0; seconds < 3600; ++seconds) {
      const Answer now = co_await ask("cell.status");
      if (now->at("state").as_string() == state) co_return;
      co_await pass(1s);
    }
    ADD_FAILURE() << "never " << state;
  }
  /// Waits for a pause, touches the points in turn from the first on, and resumes.
  Wait touch(std::size_t first, std::size_t count) {
    for (std::size_t i = first; i < first + count; ++i) {
      co_await until_state("paused");
      mock.start_motion(hand.touching(X_BU * fixture_mm[i], kTcp_mm), 100);
      co_await pass(30s);
      const Answer resumed = co_await ask("campaign.resume");
      EXPECT_TRUE(resumed) << resumed.error().message;
      co_await pass(5s);
    }
  }
  Wait started(json::object params = base_order()) {
    const Answer begun = co_await ask("campaign.start", params);
    EXPECT_TRUE(begun) << begun.error().message;
  }
  Wait measured() {
    co_await started();
    co_await touch(0, 3);
    co_await campaign_ended();
  }
  /// That the frame is where the fixture stands, as a tracker would see it and as well as a model of 16 poses
  /// knows.
  void expect_true(const json::value& found) {
    const auto model = config::parse_model(store->model("m1").value()->yaml, "m1");
    const Eigen::Isometry3d X = record::read_frame_document(found.at("frame")).value().X;
    for (const Eigen::Vector3d& p_mm : fixture_mm) {
      const Eigen::Vector3d by_model_mm = model.cell.base.isometry() * (X * p_mm);
      EXPECT_LT((by_model_mm - truth.truth.X_WB * (X_BU * p_mm)).norm(), 0.5);
    }
  }

  const Eigen::Vector3d kTcp_mm{-40, 110, 230};
  const Eigen::Isometry3d X_BU = pose_from_kuka({1400, -300, 500}, {30, 2, -1});
  const std::vector<Eigen::Vector3d> fixture_mm{{0, 0, 0}, {500, 0, 0}, {-60, 400, 0}};
  test::JoggingHand hand{truth.truth.robot, 0.01, 11};
};

TEST_F(TouchedBaseServiceTest, TheToolInUseMeasuresABase) {
  have_tool();
  play([&]() -> Wait { co_await measured(); });
  const json::value found = *call("campaign.get");
  EXPECT_EQ(found.at_pointer("/campaign/state"), "done") << found.at_pointer("/campaign/reason");
  EXPECT_EQ(found.at_pointer("/frame/touched_by"), 3);
  EXPECT_EQ(found.at_pointer("/frame/number"), 5);
  expect_true(found);
  EXPECT_THAT(std::string{found.at_pointer("/frame/yaml").as_string()}, HasSubstr("frame:"));
  EXPECT_THAT(std::string{call("campaign.export")->at("data").as_string()},
              AllOf(StartsWith("point,q1,q2,q3,q4,q5,q6\norigin,"), HasSubstr("\nx,"), HasSubstr("\nxy,")));
}

TEST_F(TouchedBaseServiceTest, NothingPretendsThatATrackerReadIt) {
  have_tool();
  play([&]() -> Wait { co_await measured(); });
  const json::value points = call("campaign.points")->at("points");
  ASSERT_THAT(points.as_array(), SizeIs(3));
  for (const json::value& point : points.as_array()) {
    EXPECT_TRUE(point.at("p_mm").is_null());
    EXPECT_TRUE(point.at("std_mm").is_null());
    EXPECT_THAT(point.at("q_actual_deg").as_array(), SizeIs(6));
    EXPECT_THAT(point.at("q_commanded_deg").as_array(), IsEmpty());
  }
  const json::value last_event = event_data(control::Topic::Measurement).back();
  EXPECT_EQ(last_event.at("smr"), "xy");
  EXPECT_TRUE(last_event.at("p_mm").is_null());
  EXPECT_TRUE(last_event.at("error_mm").is_null());
  EXPECT_EQ(last_event.at("reason"), "");
  const auto rows =
      sqlite_rows(file, "SELECT count(*) FROM point WHERE x_mm IS NULL AND temperature_c IS NULL");
  EXPECT_EQ(rows[0][0], "3");
}

TEST_F(TouchedBaseServiceTest, GoesOnWithoutATrackerAndEndsWhereItBegan) {
  have_tool();
  play([&]() -> Wait {
    co_await ask("cell.disconnect");
    tracker.leave(10h);
    co_await measured();
    const Answer now = co_await ask("cell.status");
    EXPECT_EQ(now->at("state"), "disconnected");
    EXPECT_THAT(now->at("faults").as_array(), IsEmpty());
  });
  EXPECT_EQ(call("campaign.get")->at_pointer("/campaign/state"), "done");
  EXPECT_EQ(call("campaign.get")->at_pointer("/campaign/tracker_model"), "");
}

TEST_F(TouchedBaseServiceTest, LeavesACellReadyThatWasReady) {
  have_tool();
  play([&]() -> Wait {
    co_await ask("cell.disconnect");
    co_await connected();
    co_await measured();
    const Answer now = co_await ask("cell.status");
    EXPECT_EQ(now->at("state"), "ready");
    EXPECT_TRUE(now->at_pointer("/tracker/connected").as_bool());
  });
}

TEST_F(TouchedBaseServiceTest, WaitsForNoProgramOfAnArmThatIsJogged) {
  have_tool();
  play([&]() -> Wait {
    co_await started();
    co_await until_state("paused");
    robot.press_emergency_stop(true);  // as in T1: nothing may be moved by the program
    co_await pass(5min);
    const Answer now = co_await ask("cell.status");
    EXPECT_TRUE(now->at("waiting").is_null()) << now->at("waiting");
    EXPECT_EQ(now->at("state_text"),
              "touch point \"origin\" of base 5 with the TCP of tool 3, then resume the campaign");
    co_await touch(0, 3);
    co_await campaign_ended();
  });
  EXPECT_EQ(call("campaign.get")->at_pointer("/campaign/state"), "done");
}

TEST_F(TouchedBaseServiceTest, AsksAgainWhereTheControllerWasAwayAndGoesOnAsSoonAsItAnswers) {
  have_tool();
  play([&]() -> Wait {
    co_await started();
    co_await until_state("paused");
    robot.leave(2min);
    co_await pass(30s);
    const Answer away = co_await ask("cell.status");
    EXPECT_EQ(away->at("state"), "paused");
    co_await ask("campaign.resume");
    co_await pass(10s);
    const Answer asked = co_await ask("cell.status");
    EXPECT_THAT(std::string{asked->at("state_text").as_string()},
                AllOf(HasSubstr("the controller does not answer"), HasSubstr("touch point \"origin\"")));
    co_await pass(3min);
    co_await touch(0, 3);
    co_await campaign_ended();
  });
  EXPECT_EQ(call("campaign.get")->at_pointer("/campaign/state"), "done");
}

TEST_F(TouchedBaseServiceTest, AnInterruptedOneKeepsItsTouchesAndGoesOnWithTheNext) {
  have_tool();
  play([&]() -> Wait {
    co_await started();
    co_await touch(0, 2);
    co_await cell.shut_down();
    co_await pass(10s);
    co_await ask("cell.acknowledge");
  });
  const std::string id = store->last_campaign().value()->id;
  EXPECT_EQ(store->last_campaign().value()->state, "interrupted");
  EXPECT_EQ(call("cell.status")->at_pointer("/interrupted/0/done"), 2);
  // Whatever is in use meanwhile, the rest is touched by the same tool and computed by the same model.
  EXPECT_TRUE(call("tool.deactivate", {{"number", 3}}));
  EXPECT_TRUE(call("model.activate", {{"id", "m2"}}));
  play([&]() -> Wait {
    json::object params{{"id", id}};
    const Answer resumed = co_await ask("campaign.resume", params);
    EXPECT_TRUE(resumed) << resumed.error().message;
    co_await until_state("paused");
    const Answer now = co_await ask("cell.status");
    EXPECT_THAT(std::string{now->at("state_text").as_string()}, StartsWith("touch point \"xy\" of base 5"));
    co_await touch(2, 1);
    co_await campaign_ended();
  });
  const json::value found = *call("campaign.get");
  EXPECT_EQ(found.at_pointer("/campaign/state"), "done") << found.at_pointer("/campaign/reason");
  EXPECT_THAT(found.at("interruptions").as_array(), SizeIs(1));
  EXPECT_EQ(found.at_pointer("/frame/touched_by"), 3);
  expect_true(found);
}

TEST_F(TouchedBaseServiceTest, RefusesWhatCannotBeTouched) {
  const auto why = [&](json::object more, const char* without = "") {
    json::object params = base_order();
    for (const auto& [key, value] : more) params[key] = value;
    params.erase(without);
    return refused("campaign.start", params);
  };
  EXPECT_EQ(why({}),
            "params.touch: no tool 3 is in use: measure it (truepose campaign start --tool 3), then take it "
            "into use (truepose tools activate ID)");
  have_tool();
  EXPECT_THAT(why({{"at", {{1, 2, 3}, {4, 5, 6}, {7, 8, 9}}}}),
              HasSubstr("params.at: the tracker looks for no points that touch asks for"));
  EXPECT_THAT(why({}, "touch"),
              HasSubstr("params.at: missing: the tracker needs the rough position of each point"));
  EXPECT_THAT(why({}, "points"), HasSubstr("params.points"));
  EXPECT_THAT(why({{"points", {"a", "b", "c"}}}), HasSubstr("the points say no frame"));
  EXPECT_THAT(why({{"nominal", {{0, 0, 0}}}}),
              HasSubstr("params.nominal: expected a row for each of the points"));
  EXPECT_THAT(why({{"touch", 0}}), HasSubstr("params.touch"));
  EXPECT_THAT(refused("campaign.start", {{"kind", "tool"}, {"number", 3}, {"touch", 3}}),
              HasSubstr("params.touch"));
  ASSERT_TRUE(call("model.deactivate"));
  EXPECT_THAT(why({}), HasSubstr("no model is active"));
}

}  // namespace
}  // namespace truepose::daemon
