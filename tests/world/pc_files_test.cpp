#include "tests/world/pc_files.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sqlite3.h>

#include <cstdint>
#include <filesystem>
#include <functional>
#include <set>
#include <string>

#include "config/text_file.hpp"
#include "tests/temp_folder.hpp"

namespace truepose::world {
namespace {

namespace fs = std::filesystem;
using config::synced;
using testing::ElementsAre;

/// The content of "file" in an empty folder, after some work and a loss of power: of many seeds.
std::set<std::string> left_by(const std::function<void(const TempFolder& folder)>& work) {
  constexpr std::uint64_t kSeeds = 200;
  std::set<std::string> left;
  for (std::uint64_t seed = 0; seed < kSeeds; ++seed) {
    const TempFolder folder;
    test::FailingDisk disk{seed};
    PcFiles files{folder.path(), "run", seed, disk};
    work(folder);
    files.lose_power();
    const fs::path file = folder.path() / "file";
    left.insert(fs::exists(file) ? config::read_bytes(file) : "missing");
  }
  return left;
}

TEST(PcFiles, KeepAtALossOfPowerWhatWasSynced) {
  const auto left = left_by([](const TempFolder& folder) {
    EXPECT_TRUE(synced(folder.write("file", "old")));
    EXPECT_TRUE(synced(folder.path()));
  });
  EXPECT_THAT(left, ElementsAre("old"));
}

TEST(PcFiles, LoseOrTearWhatWasWrittenSince) {
  const std::string old(700, 'o'), more(700, 'm');
  const auto left = left_by([&](const TempFolder& folder) {
    EXPECT_TRUE(synced(folder.write("file", old)));
    EXPECT_TRUE(synced(folder.path()));
    folder.write("file", old + more);
  });
  EXPECT_THAT(left, ElementsAre(old, old + more.substr(0, 324), old + more));
}

TEST(PcFiles, LoseANewFileOfAFolderThatWasNotSynced) {
  const auto left =
      left_by([](const TempFolder& folder) { EXPECT_TRUE(synced(folder.write("file", "new"))); });
  EXPECT_THAT(left, ElementsAre("missing", "new"));
}

TEST(PcFiles, HaveUnderANameTheOldFileOrTheNewOneUntilTheirFolderIsSynced) {
  for (const bool folder_too : {false, true}) {
    const auto left = left_by([&](const TempFolder& folder) {
      EXPECT_TRUE(synced(folder.write("file", "old")));
      EXPECT_TRUE(synced(folder.path()));
      const fs::path next = folder.write("next", "new");
      EXPECT_TRUE(synced(next));
      fs::rename(next, folder.path() / "file");
      EXPECT_TRUE(!folder_too || synced(folder.path()));
    });
    EXPECT_EQ(left, folder_too ? std::set<std::string>{"new"} : (std::set<std::string>{"new", "old"}));
  }
}

// ---- SQLite's ----

/// A database with one number in it.
void make_database(const fs::path& file, int number) {
  sqlite3* database = nullptr;
  ASSERT_EQ(sqlite3_open(file.c_str(), &database), SQLITE_OK);
  const std::string sql = "CREATE TABLE t (n); INSERT INTO t VALUES (" + std::to_string(number) + ")";
  EXPECT_EQ(sqlite3_exec(database, sql.c_str(), nullptr, nullptr, nullptr), SQLITE_OK);
  sqlite3_close(database);
}

int number_in_database(const fs::path& file) {
  sqlite3* database = nullptr;
  sqlite3_stmt* query = nullptr;
  sqlite3_open(file.c_str(), &database);
  sqlite3_prepare_v2(database, "SELECT n FROM t", -1, &query, nullptr);
  const int number = sqlite3_step(query) == SQLITE_ROW ? sqlite3_column_int(query, 0) : -1;
  sqlite3_finalize(query);
  sqlite3_close(database);
  return number;
}

TEST(PcFiles, OfSqliteFollowARenameAndItsLoss) {
  for (const bool folder_too : {false, true}) {
    std::set<int> left;
    for (std::uint64_t seed = 0; seed < 20; ++seed) {
      const TempFolder folder;
      test::FailingDisk disk{seed};
      PcFiles files{folder.path(), "run", seed, disk};
      const fs::path file = folder.path() / "file", next = folder.path() / "next";
      make_database(file, 1);
      make_database(next, 2);
      EXPECT_TRUE(synced(folder.path()));
      fs::rename(next, file);
      EXPECT_EQ(number_in_database(file), 2);
      EXPECT_TRUE(!folder_too || synced(folder.path()));
      files.lose_power();
      disk.restore_power();
      left.insert(number_in_database(file));
    }
    EXPECT_EQ(left, folder_too ? std::set{2} : (std::set{1, 2}));
  }
}

}  // namespace
}  // namespace truepose::world
