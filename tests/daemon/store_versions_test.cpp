#include "daemon/store/campaign_plan.hpp"
#include "tests/daemon/older_store.hpp"
#include "tests/daemon/store_fixture.hpp"

namespace truepose::daemon {
namespace {

using testing::HasSubstr;

using StoreVersionsTest = StoreTest;

TEST_F(StoreVersionsTest, KeepsTheKindsOfAFileThatKnewFewer) {
  {
    Store store = open();
    CampaignRecord drift = campaign("d");
    drift.kind = "drift";
    ASSERT_TRUE(store.begin_campaign(drift));
    ASSERT_TRUE(store.add_point("d", point(2)));
  }
  make_older(file_, 2);
  Store store = open();
  EXPECT_EQ(store.campaign("d").value()->kind, "drift");
  expect_equal(store.points("d").value().at(0), point(2));
}

TEST_F(StoreVersionsTest, LeavesAFileOfANewerVersionAlone) {
  open();
  execute("PRAGMA user_version=99");
  EXPECT_THAT(why_not_opened(file_), HasSubstr("newer truepose"));
  execute("PRAGMA user_version=14");
  EXPECT_EQ(why_not_opened(file_), "");
}

TEST_F(StoreVersionsTest, BringsAFileOfBeforeCampaignsCouldGoOnUpToDate) {
  for (const int version : {13, 12, 11, 10, 9, 8, 7, 6}) {
    SCOPED_TRACE(version);
    std::filesystem::remove(file_);
    {
      Store store = open();
      CampaignRecord record = campaign("c1");
      if (version > 6) record.started_by = "Anna";
      ASSERT_TRUE(store.begin_campaign(record));
      ASSERT_TRUE(store.add_point("c1", point(0)));
      StoredPoint nest = point(2);
      nest.purpose = PointPurpose::Nest;
      ASSERT_TRUE(store.add_point("c1", nest));
    }
    make_older(file_, version);
    Store store = open();
    EXPECT_EQ(store.campaign("c1").value()->state, "running");
    EXPECT_EQ(store.campaign("c1").value()->started_by, version > 6 ? "Anna" : "");
    expect_equal(store.points("c1").value().at(0), point(0));
    EXPECT_EQ(store.points("c1").value().at(1).purpose, PointPurpose::Nest);
    EXPECT_EQ(store.plans().interrupt_running("2026-08-17T11:00:00Z").value(), 1);
    EXPECT_EQ(store.campaign("c1").value()->state, "failed") << "of which nobody knows the plan";
  }
}

TEST_F(StoreVersionsTest, BringsAFileOfTheFirstVersionUpToDate) {
  {
    Store store = open();
    ASSERT_TRUE(store.begin_campaign(campaign("c1")));
    ASSERT_TRUE(store.add_point("c1", point(4)));
    ASSERT_TRUE(store.add_model(model("m1", "2026-08-17T10:00:00Z")));
  }
  make_older(file_, 2);
  // As it was before points had directions and the reference pose a purpose of its own.
  execute(R"sql(
    CREATE TABLE old AS SELECT * FROM point;
    DROP TABLE point;
    CREATE TABLE point (number INTEGER PRIMARY KEY, campaign_id TEXT NOT NULL REFERENCES campaign (id),
      pose INTEGER NOT NULL, purpose TEXT NOT NULL CHECK (purpose IN ('identify', 'validate', 'remeasure')),
      q_target TEXT NOT NULL, q_commanded TEXT NOT NULL, q_actual TEXT NOT NULL, smr TEXT NOT NULL,
      x_mm REAL NOT NULL, y_mm REAL NOT NULL, z_mm REAL NOT NULL, std_x_mm REAL NOT NULL, std_y_mm REAL NOT NULL,
      std_z_mm REAL NOT NULL, temperature_c REAL NOT NULL, pressure_mbar REAL NOT NULL,
      humidity_percent REAL NOT NULL, time TEXT NOT NULL) STRICT;
    INSERT INTO point SELECT number, campaign_id, pose, purpose, q_target, q_commanded, q_actual, smr, x_mm, y_mm, z_mm,
      std_x_mm, std_y_mm, std_z_mm, temperature_c, pressure_mbar, humidity_percent, time FROM old;
    DROP TABLE old;
    CREATE INDEX point_of_campaign ON point (campaign_id);
    ALTER TABLE campaign DROP COLUMN kind;
    ALTER TABLE model RENAME COLUMN validation_after_mm TO validation_geometric_mm;
    PRAGMA user_version=1)sql");

  Store store = open();
  StoredPoint expected = point(4);
  expected.direction.clear();
  const auto points = store.points("c1").value();
  ASSERT_EQ(points.size(), 1U);
  expect_equal(points[0], expected);
  EXPECT_EQ(store.model("m1").value()->validation_after_mm, 0.04);
  EXPECT_EQ(store.model("m1").value()->sha256, "") << "a hash made now would vouch for whatever became of it";
  EXPECT_EQ(store.model("m1").value()->largest_correction_deg, 0);
  EXPECT_TRUE(store.add_point("c1", point(3)));
  EXPECT_EQ(store.points("c1").value().at(1).purpose, PointPurpose::Reference);
}

}  // namespace
}  // namespace truepose::daemon
