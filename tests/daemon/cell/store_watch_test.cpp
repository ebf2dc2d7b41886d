// A store that cannot be written to while the cell works.
#include "daemon/cell/store_watch.hpp"

#include "tests/daemon/cell_fixture.hpp"
#include "tests/daemon/failing_disk.hpp"
#include "tests/trials.hpp"

namespace truepose::daemon {
namespace {

namespace fs = std::filesystem;
namespace json = boost::json;
using namespace std::chrono_literals;
using testing::AllOf;
using testing::Contains;
using testing::HasSubstr;
using testing::Not;

void expect_done_with_each_pose_once(const json::value& campaign) {
  EXPECT_EQ(campaign.at_pointer("/campaign/state"), "done");
  EXPECT_EQ(campaign.at("points_total"), 28);
  EXPECT_TRUE(campaign.at("skipped").as_array().empty());
}

/// Before the cell, whose store is on it.
struct OnADisk {
  test::FailingDisk disk;
};

struct StoreWatchTest : OnADisk, CellTest {
  StoreWatchTest() {
    config.campaign.remeasure = false;
    EXPECT_TRUE(store->begin_events(1'000'000));  // as a daemon does
    load();
  }
  void fill() { disk.fail_after(0, test::FailingDisk::Fault::Full); }
  void make_room() { disk.repair(); }
  std::vector<std::string> allowed() {
    const json::value now = status();  // outlives the loop
    std::vector<std::string> methods;
    for (const json::value& method : now.at("allowed").as_array()) methods.emplace_back(method.as_string());
    return methods;
  }
  bool stands(const std::string& code) {
    const json::value now = status();
    return std::ranges::any_of(now.at("faults").as_array(), [&](const json::value& fault) {
      return fault.at("code") == json::value(code);
    });
  }
};

TEST_F(StoreWatchTest, AFullDiskPausesACampaignWhichGoesOnWithItsPointOnceThereIsRoom) {
  play([this]() -> Wait {
    co_await ask("campaign.start");
    co_await pass(1min);
    fill();
    Answer now = co_await ask("cell.status");
    for (; now->at("state") != "paused"; now = co_await ask("cell.status")) co_await pass(1s);
    const auto measured = now->at_pointer("/campaign/done");
    const JointVector stands = mock.q();
    co_await pass(all_trials() ? 1h : 10min);
    EXPECT_EQ(mock.q(), stands);

    Answer answer = co_await ask("campaign.resume");
    EXPECT_THAT(answer.error().message, HasSubstr("then acknowledge (cell.acknowledge)"));
    answer = co_await ask("cell.acknowledge");
    EXPECT_THAT(answer.error().message, HasSubstr("still cannot be written to"));
    make_room();
    answer = co_await ask("cell.acknowledge");
    EXPECT_TRUE(answer) << answer.error().message;
    EXPECT_EQ(answer->at("state"), "paused") << "a person resumes it";
    now = co_await ask("cell.status");
    EXPECT_THAT(now->at("state_text").as_string().c_str(),
                AllOf(HasSubstr("resume the campaign"), Not(HasSubstr("acknowledge"))));
    answer = co_await ask("campaign.resume");
    EXPECT_TRUE(answer) << answer.error().message;
    co_await campaign_ended();
    EXPECT_NE(measured, json::value{});
  });
  expect_done_with_each_pose_once(call("campaign.get", {{"points_limit", 100}}).value());
}

TEST_F(StoreWatchTest, ADiskThatFailsForAMomentPausesACampaignWhichGoesOnWithItsPoint) {
  play([this]() -> Wait {
    co_await ask("campaign.start");
    co_await pass(1min);
    disk.fail_after(0, test::FailingDisk::Fault::Broken, 3);
    Answer now = co_await ask("cell.status");
    for (; now->at("state") != "paused"; now = co_await ask("cell.status")) co_await pass(1s);
    EXPECT_EQ(now->at_pointer("/faults/0/code"), "E_STORE");
    EXPECT_THAT(fault_of(*now), HasSubstr("disk I/O error"));
    disk.repair();
    EXPECT_TRUE(co_await ask("cell.acknowledge"));
    EXPECT_TRUE(co_await ask("campaign.resume"));
    co_await campaign_ended();
  });
  expect_done_with_each_pose_once(call("campaign.get", {{"points_limit", 100}}).value());
}

TEST_F(StoreWatchTest, NothingNewIsBegunUntilItIsAcknowledged) {
  cell.store_failed({"cell.db: full", true});
  EXPECT_TRUE(stands("E_STORE"));
  EXPECT_THAT(refused("campaign.start"), AllOf(HasSubstr("cell.db: full"), HasSubstr("cell.acknowledge")));
  EXPECT_THAT(refused("drift.check"), HasSubstr("cell.db: full"));
  EXPECT_THAT(refused("campaign.identify", {{"id", "c1"}}), HasSubstr("cell.db: full"));
  EXPECT_THAT(allowed(), Contains("cell.acknowledge"));
  EXPECT_TRUE(call("cell.acknowledge"));
  EXPECT_FALSE(stands("E_STORE"));
  EXPECT_THAT(allowed(), Not(Contains("cell.acknowledge")));
  EXPECT_EQ(status().at("state"), "disconnected");
}

TEST_F(StoreWatchTest, AllowsNothingThatItRefuses) {
  play([this]() -> Wait {
    co_await connected();
    cell.store_failed({"cell.db: full", true});
    const Answer now = co_await ask("cell.status");
    EXPECT_EQ(control::json_text(now->at("allowed")), R"(["cell.disconnect","cell.acknowledge"])");
    for (const char* method : {"campaign.start", "drift.check", "stream.start", "stream.arm"}) {
      const Answer refused = co_await ask(method);
      EXPECT_EQ(refused.error().code, control::ErrorCode::Store) << method;
      EXPECT_THAT(refused.error().message, AllOf(HasSubstr("cell.db: full"), HasSubstr("cell.acknowledge")));
    }
    EXPECT_TRUE(co_await ask("cell.disconnect"));
  });
}

TEST_F(StoreWatchTest, AllowsNothingWithoutAModelThatNeedsOne) {
  EXPECT_TRUE(call("model.deactivate"));
  play([this]() -> Wait {
    for (const bool ready : {false, true}) {
      if (ready) co_await connected();
      const Answer now = co_await ask("cell.status");
      const std::string text = control::json_text(now->at("allowed"));
      for (const char* method : {"stream.start", "stream.arm", "drift.check"}) {
        EXPECT_THAT(text, Not(HasSubstr(method)));
        EXPECT_THAT((co_await ask(method)).error().message, HasSubstr("no model is active"));
      }
      EXPECT_THAT(text, HasSubstr("campaign.start"));
    }
  });
}

TEST_F(StoreWatchTest, ACampaignIsNotBegunOnAFullDiskAndTheDevicesStay) {
  play([this]() -> Wait {
    co_await connected();
    fill();
    const Answer refused = co_await ask("campaign.start");
    EXPECT_EQ(refused.error().code, control::ErrorCode::Store);
    const Answer now = co_await ask("cell.status");
    EXPECT_EQ(now->at("state"), "ready");
    EXPECT_EQ(now->at_pointer("/robot/connected"), true);
    EXPECT_EQ(now->at_pointer("/faults/0/code"), "E_STORE");
    make_room();
    EXPECT_TRUE(co_await ask("cell.acknowledge"));
    EXPECT_TRUE(co_await ask("campaign.start"));
    EXPECT_TRUE(co_await ask("campaign.abort"));
  });
}

TEST_F(StoreWatchTest, ACampaignThatTheStoreDoesNotTakeAtItsBeginningIsNoFaultOfTheCell) {
  execute("CREATE TRIGGER broken BEFORE INSERT ON campaign BEGIN SELECT RAISE(ABORT, 'broken'); END");
  play([this]() -> Wait {
    co_await connected();
    EXPECT_TRUE(co_await ask("campaign.start"));
    co_await campaign_ended();
    const Answer now = co_await ask("cell.status");
    EXPECT_EQ(now->at("state"), "ready");
    EXPECT_EQ(now->at_pointer("/robot/connected"), true);
    EXPECT_EQ(now->at_pointer("/faults/0/code"), "E_STORE");
  });
}

TEST_F(StoreWatchTest, AModelIsDeactivatedOnAFullDiskAndStoredOnceThatIsPossible) {
  play([this]() -> Wait {
    fill();
    EXPECT_TRUE(co_await ask("model.deactivate"));
    const Answer now = co_await ask("cell.status");
    EXPECT_EQ(now->at_pointer("/faults/0/code"), "E_STORE");
    EXPECT_TRUE(now->at("model").is_null());
    make_room();
    co_await pass(2s);
  });
  EXPECT_FALSE(store->active_model().value()) << "without anybody's doing";
  EXPECT_TRUE(stands("E_STORE")) << "until somebody has seen it";
}

TEST_F(StoreWatchTest, AStreamIsDisarmedOnAFullDiskAndStaysSoInTheNextDaemon) {
  play([this]() -> Wait {
    EXPECT_TRUE(co_await ask("stream.arm"));
    fill();
    EXPECT_TRUE(co_await ask("stream.disarm"));
    const Answer now = co_await ask("cell.status");
    EXPECT_EQ(now->at("state"), "disconnected");
    EXPECT_EQ(now->at_pointer("/faults/0/code"), "E_STORE");
    make_room();
    co_await pass(2s);
  });
  EXPECT_EQ(store->armed_since().value(), "");
}

TEST_F(StoreWatchTest, IsReportedOnceHoweverOftenItFails) {
  for (int i = 0; i < 5; ++i) cell.store_failed({"cell.db: full", true});
  EXPECT_THAT(event_data(control::Topic::Fault), testing::SizeIs(1));
}

TEST_F(StoreWatchTest, TheEndOfACampaignThatTheStoreDidNotTakeIsWrittenOnceItDoes) {
  execute(
      "CREATE TRIGGER broken BEFORE UPDATE OF state ON campaign BEGIN SELECT RAISE(ABORT, 'broken'); END");
  play([this]() -> Wait {
    co_await ask("campaign.start");
    co_await campaign_ended();
  });
  EXPECT_EQ(status().at("state"), "fault");
  EXPECT_TRUE(stands("E_STORE"));
  const std::string id{call("campaign.get")->at_pointer("/campaign/id").as_string()};
  EXPECT_EQ(store->campaign(id).value()->state, "running");
  execute("DROP TRIGGER broken");
  const Answer acknowledged = call("cell.acknowledge");
  ASSERT_TRUE(acknowledged) << acknowledged.error().message;
  EXPECT_EQ(acknowledged->at("state"), "disconnected");
  EXPECT_EQ(store->campaign(id).value()->state, "done");
  EXPECT_EQ(status().at_pointer("/model/id"), json::value(store->campaign(id).value()->model_id))
      << "and its model in force";
}

struct LostStoreTest : CellTest {
  LostStoreTest() {
    config.campaign.remeasure = false;
    load();
  }
  void move_away() const { fs::rename(file, away); }
  void put_back() const { fs::rename(away, file); }
  const fs::path away = folder.path() / "away";
};

TEST_F(LostStoreTest, IsFoundOutWithinASecondAndNothingIsBegunUntilItIsBack) {
  play([this]() -> Wait {
    co_await connected();
    co_await pass(2s);
    EXPECT_EQ(fault_of(*co_await ask("cell.status")), "");
    move_away();
    co_await pass(2s);
    EXPECT_THAT(fault_of(*co_await ask("cell.status")),
                AllOf(HasSubstr(file.string() + ": is another file than the daemon opened"),
                      HasSubstr("Put it back"), HasSubstr("truepose backup")));
    EXPECT_EQ((co_await ask("campaign.start")).error().code, control::ErrorCode::Store);
    EXPECT_THAT((co_await ask("cell.acknowledge")).error().message,
                HasSubstr("is another file than the daemon opened"));
    put_back();
    EXPECT_TRUE(co_await ask("cell.acknowledge"));
    EXPECT_TRUE(co_await ask("campaign.start"));
    co_await campaign_ended();
  });
  EXPECT_EQ(call("campaign.get")->at_pointer("/campaign/state"), "done");
}

TEST_F(LostStoreTest, ActivatesNoModelWhetherItWasDeletedOrReplaced) {
  const fs::path other = folder.path() / "other";
  fs::copy_file(file, other);
  move_away();
  EXPECT_THAT(refused("model.activate", {{"id", "m2"}}), HasSubstr("is another file than the daemon opened"));
  fs::rename(other, file);
  EXPECT_THAT(refused("model.activate", {{"id", "m2"}}), HasSubstr("is another file than the daemon opened"));
  EXPECT_EQ(status().at_pointer("/model/id"), "m1");
  put_back();
  EXPECT_TRUE(call("model.activate", {{"id", "m2"}}));
}

TEST_F(LostStoreTest, ItsLogsAreFoundMissingWithinASecondAndNothingStoredIsLost) {
  for (const bool replaced : {false, true}) {
    EXPECT_TRUE(store->begin_campaign(
        {.id = replaced ? "c8" : "c9", .started = "2026-08-17T10:00:00Z", .state = "running"}));
    for (const char* log : {"-wal", "-shm"}) {
      fs::remove(file.string() + log);
      if (replaced) std::ofstream{file.string() + log};
    }
    EXPECT_THAT(refused("model.activate", {{"id", "m2"}}), HasSubstr("-wal: was deleted"));
    play([this]() -> Wait {
      co_await pass(2s);
      EXPECT_THAT(fault_of(*co_await ask("cell.status")),
                  AllOf(HasSubstr(file.string() + "-wal: was deleted"), HasSubstr("acknowledge")));
    });
    const fs::path copy = folder.path() / "copy";
    fs::copy_file(file, copy, fs::copy_options::overwrite_existing);
    EXPECT_TRUE(Store::open_to_read(copy)->campaign(replaced ? "c8" : "c9").value()) << "in the file alone";
    EXPECT_TRUE(call("cell.acknowledge"));
    EXPECT_TRUE(call("model.activate", {{"id", "m2"}}));
    EXPECT_TRUE(call("model.activate", {{"id", "m1"}}));
  }
}

TEST_F(LostStoreTest, ALogThatAnotherProgramWroteIsNotTakenForItsOwn) {
  fs::remove(file.string() + "-wal");
  std::ofstream{file.string() + "-wal"} << "frames of another";
  play([this]() -> Wait { co_await pass(2s); });
  EXPECT_THAT(fault(), HasSubstr("-wal: was deleted"));
  EXPECT_THAT(refused("cell.acknowledge"), HasSubstr("another program writes to the store"));
  fs::remove(file.string() + "-wal");
  EXPECT_TRUE(call("cell.acknowledge"));
  EXPECT_TRUE(call("model.activate", {{"id", "m2"}}));
}

TEST_F(LostStoreTest, PausesACampaignWhichGoesOnOnceItIsBack) {
  play([this]() -> Wait {
    co_await ask("campaign.start");
    co_await pass(1min);
    move_away();
    Answer now = co_await ask("cell.status");
    for (; now->at("state") != "paused" && !now->at("campaign").is_null(); now = co_await ask("cell.status"))
      co_await pass(1s);
    EXPECT_EQ(now->at("state"), "paused");
    put_back();
    EXPECT_TRUE(co_await ask("cell.acknowledge"));
    EXPECT_TRUE(co_await ask("campaign.resume"));
    co_await campaign_ended();
  });
  expect_done_with_each_pose_once(call("campaign.get", {{"points_limit", 100}}).value());
}

}  // namespace
}  // namespace truepose::daemon
