#include <array>

#include "tests/daemon/store_fixture.hpp"
#include "tests/integration/sqlite_rows.hpp"

namespace truepose::daemon {
namespace {

using testing::HasSubstr;

/// A store that this program wrote, and the program of the next version of the schema.
class StoreVersions : public StoreTest {
 protected:
  StoreVersions() {
    Store store = open();
    EXPECT_TRUE(store.begin_campaign(campaign("c1")));
    EXPECT_TRUE(store.add_point("c1", point(4)));
  }

  static std::size_t points_in(StoreResult<Store> store) {
    return store ? store->points("c1").value().size() : 0;
  }
  std::string version(const std::filesystem::path& file) {
    return sqlite_rows(file, "PRAGMA user_version")[0][0];
  }

  const std::array<const char*, 2> steps_{kSchemaSteps[0], "CREATE TABLE added (one INTEGER) STRICT;"};
};

TEST_F(StoreVersions, AnOlderStoreIsMigratedAndACopyOfItKept) {
  ASSERT_EQ(version(file_), "1");
  EXPECT_EQ(points_in(Store::open(file_, steps_)), 1U);
  EXPECT_EQ(version(file_), "2");
  EXPECT_EQ(sqlite_rows(file_, "SELECT count(*) FROM added")[0][0], "0");
  EXPECT_EQ(version(file_.string() + ".schema-1"), "1");
  EXPECT_EQ(points_in(Store::open(file_.string() + ".schema-1")), 1U);
  EXPECT_EQ(points_in(Store::open(file_, steps_)), 1U) << "once more";
}

TEST_F(StoreVersions, AnOlderStoreIsReadWithoutAChange) {
  EXPECT_EQ(points_in(Store::open_to_read(file_, steps_)), 1U);
  EXPECT_EQ(version(file_), "1");
}

TEST_F(StoreVersions, AMigrationThatFailsLeavesTheStoreAsItWas) {
  const std::array<const char*, 2> bad{kSchemaSteps[0], "CREATE TABLE added (one INTEGER) STRICT; NO SQL;"};
  EXPECT_FALSE(Store::open(file_, bad));
  EXPECT_EQ(version(file_), "1");
  EXPECT_EQ(points_in(open()), 1U);
}

TEST_F(StoreVersions, ANewerStoreIsLeftAlone) {
  execute("PRAGMA user_version=99");
  EXPECT_THAT(why_not_opened(file_), HasSubstr("schema 99, this one knows 1 to 1"));
  execute("PRAGMA user_version=1");
  EXPECT_EQ(why_not_opened(file_), "");
}

}  // namespace
}  // namespace truepose::daemon
