#include "daemon/store/store.hpp"

#include <sys/stat.h>

#include <algorithm>
#include <cstdint>
#include <fstream>

#include "daemon/store/campaign_plan.hpp"
#include "tests/daemon/as_nobody.hpp"
#include "tests/daemon/store_fixture.hpp"
#include "tests/integration/sqlite_rows.hpp"

namespace truepose::daemon {
namespace {

using testing::HasSubstr;

TEST_F(StoreTest, GivesPointsAndSkippedPosesBackToTheLastBitAfterReopening) {
  {
    Store store = open();
    ASSERT_TRUE(store.begin_campaign(campaign("c1")));
    for (int pose = 0; pose < 5; ++pose) ASSERT_TRUE(store.add_point("c1", point(pose)));
    ASSERT_TRUE(store.add_skipped("c1", {.pose = 7, .attempts = 3, .reason = "no reflector; it's hidden"}));
  }
  Store store = open();
  const auto points = store.points("c1");
  ASSERT_TRUE(points);
  ASSERT_EQ(points->size(), 5u);
  for (int pose = 0; pose < 5; ++pose) expect_equal((*points)[static_cast<std::size_t>(pose)], point(pose));
  const auto skipped = store.skipped("c1");
  ASSERT_TRUE(skipped);
  ASSERT_EQ(skipped->size(), 1u);
  EXPECT_EQ((*skipped)[0].reason, "no reflector; it's hidden");
  EXPECT_EQ((*skipped)[0].attempts, 3);
  EXPECT_TRUE(store.points("unknown")->empty());
}

TEST_F(StoreTest, KeepsCampaignsNewestFirstAndTheirDocumentsApart) {
  Store store = open();
  ASSERT_TRUE(store.begin_campaign(campaign("c1")));
  CampaignRecord later = campaign("c2");
  later.started = "2026-08-18T10:00:00Z";
  ASSERT_TRUE(store.begin_campaign(later));
  CampaignRecord ended = campaign("c1");
  ended.state = "done";
  ended.ended = "2026-08-17T11:00:00Z";
  ended.model_id = "m1";
  ended.document = "{\"rank\": 27}";
  ASSERT_TRUE(store.end_campaign(ended));

  const auto list = store.campaigns();
  ASSERT_TRUE(list);
  ASSERT_EQ(list->size(), 2u);
  EXPECT_EQ((*list)[0].id, "c2");
  EXPECT_EQ((*list)[1].state, "done");
  EXPECT_EQ((*list)[1].document, "");
  const auto one = store.campaign("c1");
  ASSERT_TRUE(one && *one);
  EXPECT_EQ((*one)->document, ended.document);
  EXPECT_EQ((*one)->tracker_serial, "123");
  EXPECT_FALSE(*store.campaign("c3"));
}

TEST_F(StoreTest, GivesTextsThatMayBeLoggedAndSentWhateverHasBecomeOfTheFile) {
  {
    Store store = open();
    ASSERT_TRUE(store.begin_campaign(campaign("c1")));
    ASSERT_TRUE(store.add_model(model("m1", "2026-08-17T10:00:00Z")));
  }
  execute(
      "UPDATE campaign SET robot_serial=CAST(x'3131FF0A1B5B324A' AS TEXT), document=CAST(x'7B0AC37D' AS "
      "TEXT)");
  execute(
      "UPDATE model SET robot_serial=CAST(x'C328' AS TEXT), yaml=CAST(x'6E616D653A20611B0A09623A2031' AS "
      "TEXT)");
  Store store = open();
  const auto read = store.campaign("c1").value().value();
  EXPECT_EQ(read.robot_serial, "11\uFFFD \uFFFD[2J");
  EXPECT_EQ(read.document, "{\n\uFFFD}");
  const auto stored = store.model("m1").value().value();
  EXPECT_EQ(stored.robot_serial, "\uFFFD(");
  EXPECT_EQ(stored.yaml, "name: a\uFFFD\n\tb: 1");
}

TEST_F(StoreTest, ListsTheCampaignThatWasBegunLastFirstWhateverTheClockSaid) {
  Store store = open();
  ASSERT_TRUE(store.begin_campaign(campaign("c1")));
  CampaignRecord set_back = campaign("c2");
  set_back.started = "2019-01-01T00:00:00Z";
  ASSERT_TRUE(store.begin_campaign(set_back));
  EXPECT_EQ(store.campaigns()->front().id, "c2");
  ASSERT_TRUE(store.add_model(model("m1", "2026-08-17T11:00:00Z")));
  ASSERT_TRUE(store.add_model(model("m2", "2019-01-01T00:00:00Z")));
  EXPECT_EQ(store.models()->front().id, "m2");
}

TEST_F(StoreTest, IsWholeInItsFileAloneAtTheEndOfACampaign) {
  Store store = open();
  ASSERT_TRUE(store.begin_campaign(campaign("c1")));
  for (int pose = 0; pose < 20; ++pose) ASSERT_TRUE(store.add_point("c1", point(pose)));
  CampaignRecord ended = campaign("c1");
  ended.state = "done";
  ended.model_id = "m1";
  ModelRecord made = model("m1", "2026-08-17T11:00:00Z");
  made.active = true;
  ASSERT_TRUE(store.end_campaign(ended, made));

  // A copy as a person makes it, of the one file that they know of, while the daemon continues.
  std::filesystem::copy_file(file_, folder_.path() / "copy.db");
  StoreResult<Store> copy = Store::open(folder_.path() / "copy.db");
  ASSERT_TRUE(copy) << copy.error().detail;
  ASSERT_EQ(copy->campaigns()->size(), 1U);
  EXPECT_EQ(copy->points("c1")->size(), 20U);
  EXPECT_EQ(copy->active_model().value()->id, "m1");
}

TEST_F(StoreTest, IsForItsOwnerAlone) {
  using std::filesystem::perms;
  const mode_t before = umask(022);
  Store store = open();
  umask(before);
  ASSERT_TRUE(store.begin_campaign(campaign("c1")));
  for (const auto& file : std::filesystem::directory_iterator{folder_.path()})
    EXPECT_EQ(file.status().permissions(), perms::owner_read | perms::owner_write) << file.path();
}

TEST_F(StoreTest, SaysInTheWordsOfTheDatabaseWhatIsWrongWithItsTables) {
  Store store = open();
  execute("ALTER TABLE skipped RENAME TO elsewhere");
  EXPECT_THAT(store.add_skipped("c1", {}).error().detail, HasSubstr("no such table: skipped"));
  execute("ALTER TABLE point RENAME COLUMN x_mm TO x");
  EXPECT_THAT(store.points("c1").error().detail, HasSubstr("no such column: x_mm"));
}

TEST_F(StoreTest, WritesTheEndOfACampaignWithItsModelAndItsActivationOrNothingOfIt) {
  Store store = open();
  ASSERT_TRUE(store.begin_campaign(campaign("c1")));
  ASSERT_TRUE(store.add_model(model("m0", "2026-08-16T11:00:00Z")));
  ASSERT_TRUE(store.activate_model("m0"));
  CampaignRecord ended = campaign("c1");
  ended.state = "done";
  ended.model_id = "m0";
  ModelRecord made = model("m0", "2026-08-17T11:00:00Z");  // an id that another model has
  made.yaml += "# another\n";
  made.active = true;
  EXPECT_FALSE(store.end_campaign(ended, made));
  EXPECT_EQ(store.campaign("c1").value()->state, "running");

  ended.model_id = made.id = "m1";
  ASSERT_TRUE(store.end_campaign(ended, made));
  EXPECT_EQ(store.campaign("c1").value()->state, "done");
  EXPECT_EQ(store.active_model().value()->id, "m1");
  EXPECT_FALSE(store.model("m0").value()->active);
}

TEST_F(StoreTest, MarksTheCampaignsThatNobodyRunsAnyMore) {
  Store store = open();
  CampaignRecord done = campaign("done"), drift = campaign("drift"), iso9283 = campaign("iso");
  ASSERT_TRUE(store.begin_campaign(done, "{}"));
  done.state = "done";
  ASSERT_TRUE(store.end_campaign(done));
  drift.kind = "drift";
  iso9283.kind = "iso9283";
  ASSERT_TRUE(store.begin_campaign(drift));
  ASSERT_TRUE(store.begin_campaign(iso9283));
  ASSERT_TRUE(store.begin_campaign(campaign("may go on"), "{}"));
  ASSERT_TRUE(store.begin_campaign(campaign("of before")));

  EXPECT_EQ(store.plans().interrupt_running("2026-08-17T11:00:00Z").value(), 4);
  const auto interrupted = store.campaign("may go on").value().value();
  EXPECT_EQ(interrupted.state, "interrupted");
  EXPECT_EQ(interrupted.ended, "2026-08-17T11:00:00Z");
  EXPECT_EQ(interrupted.reason, "the daemon ended in the middle of it");
  EXPECT_EQ(store.campaign("of before").value()->state, "failed") << "it has no plan";
  EXPECT_EQ(store.campaign("iso").value()->state, "failed");
  EXPECT_THAT(store.campaign("iso").value()->reason, HasSubstr("one series of cycles without a break"));
  EXPECT_THAT(store.campaign("drift").value()->reason, HasSubstr("start it again"));
  EXPECT_EQ(store.campaign("done").value()->state, "done");
  EXPECT_EQ(store.plans().interrupt_running("2026-08-17T12:00:00Z").value(), 0);
}

TEST_F(StoreTest, KeepsThePlanOfACampaignToTheLastBit) {
  {
    Store store = open();
    ASSERT_TRUE(store.begin_campaign(campaign("c1"), R"({"activate":true})"));
    std::vector<PlannedPose> poses{{1, PointPurpose::Identify, point(0).q_target, point(0).q_commanded, 0},
                                   {2, PointPurpose::Reference, point(1).q_target, point(1).q_target, 0}};
    ASSERT_TRUE(store.plans().add_planned("c1", poses, 40));
    poses = {{41, PointPurpose::Identify, point(2).q_target, point(2).q_target, 1}};
    ASSERT_TRUE(store.plans().add_planned("c1", poses, 41));
    ASSERT_TRUE(store.plans().keep_identified("c1", "abc"));
    poses.front().q_target *= 2;
    EXPECT_FALSE(store.plans().add_planned("c1", poses, 42)) << "a number that another pose has";
  }
  Store store = open();
  const CampaignPlan plan = store.plans().plan("c1").value().value();
  EXPECT_EQ(plan.order, R"({"activate":true})");
  EXPECT_EQ(plan.total, 41);
  EXPECT_EQ(plan.identified, "abc");
  ASSERT_EQ(plan.poses.size(), 3U);
  EXPECT_EQ(plan.poses[0].q_target, point(0).q_target);
  EXPECT_EQ(plan.poses[0].q_commanded, point(0).q_commanded);
  EXPECT_EQ(plan.poses[1].purpose, PointPurpose::Reference);
  EXPECT_EQ(plan.poses[2].pose, 41);
  EXPECT_EQ(plan.poses[2].replaces, 1);
  EXPECT_FALSE(store.plans().plan("c2").value());
}

TEST_F(StoreTest, LetsAnInterruptedCampaignGoOnAndKeepsWhatWasFound) {
  Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
  X.linear() = Eigen::AngleAxisd(1.0 / 3, Eigen::Vector3d(1, 2, 3).normalized()).toRotationMatrix();
  X.translation() = Eigen::Vector3d(1.0 / 7, -1e-17, 5);
  {
    Store store = open();
    ASSERT_TRUE(store.begin_campaign(campaign("c1"), "{}"));
    StoredPoint nest = point(3), check = point(4), face1 = point(5);
    nest.purpose = PointPurpose::Nest;
    check.purpose = PointPurpose::Check;
    face1.purpose = PointPurpose::Face1;
    for (const StoredPoint& p : {point(1), point(2), nest, check, face1})
      ASSERT_TRUE(store.add_point("c1", p));
    ASSERT_TRUE(store.add_skipped("c1", {.pose = 6, .attempts = 3, .reason = "hidden"}));
    ASSERT_TRUE(store.plans().add_planned("c1", {}, 40));
    EXPECT_FALSE(store.plans().resume("c1")) << "it still runs";
    ASSERT_TRUE(store.plans().interrupt_running("2026-08-17T11:00:00Z"));
    const auto interrupted = store.plans().interrupted().value();
    ASSERT_EQ(interrupted.size(), 1U);
    EXPECT_EQ(interrupted[0].record.id, "c1");
    EXPECT_EQ(interrupted[0].record.robot_serial, "4711");
    EXPECT_EQ(interrupted[0].done, 2);
    EXPECT_EQ(interrupted[0].skipped, 1);
    EXPECT_EQ(interrupted[0].total, 40);

    ASSERT_TRUE(store.plans().resume("c1"));
    EXPECT_EQ(store.campaign("c1").value()->state, "running");
    EXPECT_TRUE(store.plans().interrupted()->empty());
    ASSERT_TRUE(store.plans().add_resumption(
        "c1", {{"2026-08-17T11:00:00Z", "2026-08-17T12:00:00Z", "it moved"}, X}));
    StoredPoint later = point(7);
    later.resumption = 1;
    ASSERT_TRUE(store.add_point("c1", later));
  }
  Store store = open();
  const auto resumptions = store.plans().resumptions("c1").value();
  ASSERT_EQ(resumptions.size(), 1U);
  EXPECT_EQ(resumptions[0].found, "it moved");
  EXPECT_EQ(resumptions[0].interrupted, "2026-08-17T11:00:00Z");
  EXPECT_EQ(resumptions[0].X_first_now.matrix(), X.matrix());
  EXPECT_EQ(store.points("c1")->back().resumption, 1);
  EXPECT_EQ(store.points("c1")->front().resumption, 0);
}

TEST_F(StoreTest, RefusesWhatCannotBeTrue) {
  Store store = open();
  ASSERT_TRUE(store.begin_campaign(campaign("c1")));
  EXPECT_THAT(store.begin_campaign(campaign("c1")).error().detail, HasSubstr("UNIQUE"));
  EXPECT_THAT(store.add_point("c2", point(1)).error().detail, HasSubstr("FOREIGN KEY"));
  EXPECT_THAT(store.end_campaign(campaign("c2")).error().detail, HasSubstr("no such campaign"));
  EXPECT_THAT(store.activate_model("m1").error().detail, HasSubstr("no such model"));
  StoredPoint broken = point(1);
  broken.p_WS_mm->y() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(store.add_point("c1", broken).error().detail, HasSubstr("not finite"));
  CampaignRecord odd = campaign("c1");
  odd.state = "somehow";
  EXPECT_THAT(store.end_campaign(odd).error().detail, HasSubstr("CHECK"));
  EXPECT_TRUE(store.points("c1")->empty());
  EXPECT_TRUE(store.add_point("c1", point(1))) << "an error leaves the store usable";
}

TEST_F(StoreTest, HasAtMostOneActiveModel) {
  Store store = open();
  EXPECT_FALSE(*store.active_model());
  ASSERT_TRUE(store.add_model(model("m1", "2026-08-17T11:00:00Z")));
  ASSERT_TRUE(store.add_model(model("m2", "2026-08-18T11:00:00Z")));
  for (const std::string id : {"m1", "m2", "m2", "m1"}) {
    ASSERT_TRUE(store.activate_model(id));
    EXPECT_EQ((*store.active_model())->id, id);
    EXPECT_FALSE(store.activate_model("m3"));
    EXPECT_EQ((*store.active_model())->id, id) << "a failed activation changes nothing";
    const auto models = store.models();
    EXPECT_EQ(std::count_if(models->begin(), models->end(), [](const ModelRecord& m) { return m.active; }),
              1);
    EXPECT_EQ((*models)[0].id, "m2");
    EXPECT_EQ((*models)[0].yaml, "");
  }
  EXPECT_EQ((*store.model("m1"))->yaml, "name: m1\n");
  EXPECT_EQ((*store.model("m1"))->sha256, "156f890dd01a0e22971de33835aad50d24b7fd1858cfa86a894d7f1a42c55458");
  EXPECT_EQ((*store.model("m1"))->largest_correction_deg, 0.25);
  EXPECT_EQ((*store.model("m1"))->validation_before_mm, 1.0 / 3);
  ASSERT_TRUE(store.activate_model(""));
  EXPECT_FALSE(*store.active_model());
}

TEST_F(StoreTest, NeverGivesAnEventNumberTwice) {
  std::uint64_t next = 1;
  for (int round = 0; round < 5; ++round) {
    Store store = open();
    for (const std::uint64_t count : {1u, 100u, 7u}) {
      const auto first = store.reserve_event_numbers(count);
      ASSERT_TRUE(first);
      EXPECT_EQ(*first, next);
      next += count;
    }
  }
}

TEST_F(StoreTest, SaysWhyAFileCannotBeItsOwn) {
  EXPECT_THAT(why_not_opened(folder_.path() / "missing" / "cell.db"), HasSubstr("unable to open"));
  EXPECT_THAT(why_not_opened(folder_.path()), HasSubstr("unable to open"));

  const std::filesystem::path text = folder_.path() / "notes.txt";
  std::ofstream{text} << std::string(5000, 'x');
  EXPECT_THAT(why_not_opened(text), HasSubstr("not a database"));

  execute("CREATE TABLE t (x)");
  EXPECT_THAT(why_not_opened(file_), HasSubstr("another program"));
}

TEST_F(StoreTest, FindsADamagedFileWhenItOpens) {
  {
    Store store = open();
    ASSERT_TRUE(store.begin_campaign(campaign("c1")));
    for (int pose = 0; pose < 100; ++pose) ASSERT_TRUE(store.add_point("c1", point(pose)));
  }
  const auto size = std::filesystem::file_size(file_);
  std::fstream bytes{file_, std::ios::in | std::ios::out | std::ios::binary};
  bytes.seekp(static_cast<std::streamoff>(size / 2));
  bytes << std::string(size / 4, '\x5a');
  bytes.close();
  EXPECT_NE(why_not_opened(file_), "");
}

TEST_F(StoreTest, KeepsCampaignsAndPointsOfEveryKind) {
  Store store = open();
  for (const char* kind : {"calibration", "drift", "targets", "iso9283", "tool", "base"}) {
    CampaignRecord record = campaign(kind);
    record.kind = kind;
    ASSERT_TRUE(store.begin_campaign(record)) << kind;
    EXPECT_EQ(store.campaign(kind).value()->kind, kind);
  }
  StoredPoint of_target = point(0), of_cycle = point(1);
  of_target.purpose = PointPurpose::Target;
  of_cycle.purpose = PointPurpose::Cycle;
  ASSERT_TRUE(store.add_point("targets", of_target));
  ASSERT_TRUE(store.add_point("targets", of_cycle));
  const auto points = store.points("targets").value();
  ASSERT_EQ(points.size(), 2U);
  expect_equal(points[0], of_target);
  expect_equal(points[1], of_cycle);
}

TEST_F(StoreTest, KeepsThatNoTrackerReadAPointThatWasTouched) {
  StoredPoint touched = point(2);
  touched.purpose = PointPurpose::Frame;
  touched.q_target = touched.q_commanded = JointVector();
  touched.p_WS_mm.reset();
  touched.std_mm.setZero();
  touched.temperature_c = touched.pressure_mbar = touched.humidity_percent = 0;
  Store store = open();
  ASSERT_TRUE(store.begin_campaign(campaign("c1")));
  ASSERT_TRUE(store.add_point("c1", touched));
  expect_equal(store.points("c1").value().at(0), touched);
  EXPECT_EQ(sqlite_rows(file_,
                        "SELECT count(*) FROM point WHERE x_mm IS NULL AND std_x_mm IS NULL AND "
                        "pressure_mbar IS NULL")[0][0],
            "1");
  touched.purpose = PointPurpose::Identify;
  EXPECT_THAT(store.add_point("c1", touched).error().detail, HasSubstr("CHECK"))
      << "the arm is reported, or unknown";
}

TEST_F(StoreTest, KnowsWhichModelWasActiveBefore) {
  Store store = open();
  EXPECT_EQ(store.model_before().value(), std::nullopt);
  for (const char* id : {"m1", "m2", "m3"}) ASSERT_TRUE(store.add_model(model(id, "2026-08-17T10:00:00Z")));
  const auto before = [&] {
    const auto found = store.model_before().value();
    return found ? found->id : "";
  };
  ASSERT_TRUE(store.activate_model("m1"));
  EXPECT_EQ(before(), "");
  ASSERT_TRUE(store.activate_model("m3"));
  ASSERT_TRUE(store.activate_model("m3")) << "again";
  EXPECT_EQ(before(), "m1");
  ASSERT_TRUE(store.activate_model("m2"));
  EXPECT_EQ(before(), "m3");
  ASSERT_TRUE(store.activate_model(""));
  EXPECT_EQ(before(), "m2") << "which was deactivated";
  CampaignRecord made = campaign("c1");
  ASSERT_TRUE(store.begin_campaign(made));
  ModelRecord its_own = model("m4", "2026-08-17T11:00:00Z");
  its_own.active = true;
  ASSERT_TRUE(store.end_campaign(made, its_own));
  EXPECT_EQ(before(), "m2") << "before the one that a campaign activated";
}

TEST_F(StoreTest, SaysThatAFileCannotBeWritten) {
  using std::filesystem::perms;
  open();
  const perms read = perms::owner_read | perms::group_read | perms::others_read;
  const perms enter = perms::owner_exec | perms::group_exec | perms::others_exec;
  std::filesystem::permissions(file_, read);
  std::filesystem::permissions(folder_.path(), read | enter);
  const std::string why = [this] {
    const test::AsNobody nobody;
    return why_not_opened(file_);
  }();
  std::filesystem::permissions(folder_.path(), perms::owner_all);
  EXPECT_THAT(why, HasSubstr("readonly"));
}

}  // namespace
}  // namespace truepose::daemon
