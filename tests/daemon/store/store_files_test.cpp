// Copies of a store: backups while it is used, reading without a daemon, and putting one back.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <stdexcept>
#include <string>

#include "daemon/store/correction_mark.hpp"
#include "daemon/store/restore.hpp"
#include "daemon/store/runtime_folder.hpp"
#include "daemon/store/store.hpp"
#include "tests/temp_folder.hpp"

namespace truepose::daemon {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

struct StoreFiles : testing::Test {
  Store open(const fs::path& of) {
    StoreResult<Store> store = Store::open(of);
    if (!store) throw std::runtime_error(store.error().detail);
    return std::move(*store);
  }
  /// A store with a campaign of so many points.
  Store filled(int points, std::size_t bytes_of_document = 0) {
    Store store = open(file);
    CampaignRecord record;
    record.id = "c1";
    record.state = "running";
    record.document = std::string(bytes_of_document, ' ');
    EXPECT_TRUE(store.begin_campaign(record));
    for (int pose = 1; pose <= points; ++pose) add(store, pose);
    return store;
  }
  static void add(Store& store, int pose) {
    StoredPoint point;
    point.pose = pose;
    point.q_target = point.q_commanded = point.q_actual = JointVector::Constant(6, 0.1);
    point.smr = "1";
    point.p_WS_mm = Eigen::Vector3d(1, 2, 3);
    EXPECT_TRUE(store.add_point("c1", point));
  }
  static std::size_t points_in(Store store) { return store.points("c1").value().size(); }
  std::vector<std::string> names() const {
    std::vector<std::string> all;
    for (const auto& each : fs::directory_iterator{folder.path()}) all.push_back(each.path().filename());
    std::ranges::sort(all);
    return all;
  }

  TempFolder folder;
  const fs::path file = folder.path() / "cell.db", copy = folder.path() / "copy.db";
};

TEST_F(StoreFiles, AFileThatIsNoLongerTheOneThatWasOpenedTakesNothingAndCanStillBeCopied) {
  Store store = filled(3);
  remove_with_logs(file);
  EXPECT_THAT(store.activate_model("").error().detail, HasSubstr("is another file than the daemon opened"));
  const Store other = filled(1);
  EXPECT_THAT(store.activate_model("").error().detail, HasSubstr("is another file than the daemon opened"));
  EXPECT_THAT(store.try_again().error().detail, HasSubstr("is another file than the daemon opened"));
  StoreBackup backup = store.begin_backup(copy).value();
  while (!backup.step().value()) {
  }
  ASSERT_TRUE(backup.finish());
  EXPECT_EQ(points_in(open(copy)), 3U);
  EXPECT_EQ(points_in(open(file)), 1U);
}

TEST_F(StoreFiles, ABackupHasWhatWasStoredWhileItWasMade) {
  Store store = filled(1, 5'000'000);
  auto backup = store.begin_backup(copy);
  ASSERT_TRUE(backup) << backup.error().detail;
  int pose = 1, steps = 0;
  for (StoreResult<bool> done = false; !*done; ++steps) {
    done = backup->step();
    ASSERT_TRUE(done) << done.error().detail;
    add(store, ++pose);
    EXPECT_FALSE(fs::exists(copy)) << "not before it is whole";
  }
  EXPECT_GT(steps, 2);
  const auto bytes = backup->finish();
  ASSERT_TRUE(bytes) << bytes.error().detail;
  EXPECT_EQ(*bytes, fs::file_size(copy));
  EXPECT_EQ(fs::status(copy).permissions(), fs::perms::owner_read | fs::perms::owner_write);
  EXPECT_THAT(names(), testing::Each(testing::Not(HasSubstr("copy.db.part"))));
  EXPECT_THAT(names(), testing::Each(testing::Not(HasSubstr("copy.db-"))));
  const std::size_t in_copy = points_in(open(copy));
  EXPECT_GE(in_copy, static_cast<std::size_t>(pose) - 1);
}

TEST_F(StoreFiles, ABackupThatIsGivenUpLeavesNothing) {
  Store store = filled(100);
  std::ofstream{copy} << "the one of before";
  {
    auto backup = store.begin_backup(copy);
    ASSERT_TRUE(backup);
    ASSERT_TRUE(backup->step());
  }
  EXPECT_EQ(fs::file_size(copy), 17U);
  EXPECT_THAT(names(), testing::Each(testing::Not(HasSubstr("part"))));
}

TEST_F(StoreFiles, AreReadWhileADaemonHasThemAndNothingIsChanged) {
  Store store = filled(20);
  const auto before = names();
  StoreResult<Store> reader = Store::open_to_read(file);
  ASSERT_TRUE(reader) << reader.error().detail;
  EXPECT_EQ(reader->points("c1").value().size(), 20U);
  add(store, 21);
  EXPECT_EQ(reader->points("c1").value().size(), 21U);
  EXPECT_FALSE(reader->keep_armed("2026-01-01T00:00:00Z"));
  EXPECT_EQ(names(), before);
}

TEST_F(StoreFiles, ACopyIsReadInAFolderThatIsNotWritable) {
  {
    Store store = filled(20);
    CampaignRecord ended = store.campaign("c1").value().value();
    ended.state = "done";
    ASSERT_TRUE(store.end_campaign(ended));
    fs::create_directory(folder.path() / "a % of # it?");
    fs::copy_file(file, folder.path() / "a % of # it?" / "cell.db");
  }
  const fs::path apart = folder.path() / "a % of # it?";
  fs::permissions(apart, fs::perms::owner_read | fs::perms::owner_exec);
  StoreResult<Store> reader = Store::open_to_read(apart / "cell.db");
  ASSERT_TRUE(reader) << reader.error().detail;
  EXPECT_EQ(reader->points("c1").value().size(), 20U);
  EXPECT_EQ(std::distance(fs::directory_iterator{apart}, {}), 1);
  fs::permissions(apart, fs::perms::owner_all);
}

TEST_F(StoreFiles, WhatIsNoStoreIsNotRead) {
  EXPECT_THAT(Store::open_to_read(file).error().detail, HasSubstr("there is no such file"));
  std::ofstream{file} << std::string(5000, 'x');
  EXPECT_THAT(Store::open_to_read(file).error().detail, HasSubstr("not a database"));
  std::ofstream{file, std::ios::trunc};
  EXPECT_THAT(Store::open_to_read(file).error().detail, HasSubstr("is empty"));
}

struct Restoring : StoreFiles {
  /// A backup of a store that continued since, with a stream armed in both.
  Restoring() {
    Store store = filled(10);
    EXPECT_TRUE(store.keep_armed("2026-01-01T00:00:00Z"));
    EXPECT_TRUE(store.begin_events(100));
    auto backup = store.begin_backup(copy);
    while (!backup->step().value()) {
    }
    EXPECT_TRUE(backup->finish());
    add(store, 11);
    EXPECT_TRUE(store.begin_events(5'000));
  }
  std::string why_not(const fs::path& backup) {
    const auto restored = restore_store(backup, file, "now");
    return restored ? "" : restored.error();
  }
};

TEST_F(Restoring, PutsTheBackupInPlaceAndKeepsWhatWasThere) {
  const auto aside = restore_store(copy, file, "20261124T235959Z");
  ASSERT_TRUE(aside) << aside.error();
  EXPECT_EQ(*aside, file.string() + ".before-20261124T235959Z");
  EXPECT_EQ(points_in(open(*aside)), 11U);
  Store store = open(file);
  EXPECT_EQ(store.points("c1").value().size(), 10U);
  EXPECT_EQ(store.armed_since().value(), "") << "nobody armed this one";
  EXPECT_EQ(store.begin_events(100).value(), 5'101U) << "no number is given twice";
  EXPECT_FALSE(store.event_gaps(101, 5'101).value().empty());
  EXPECT_EQ(fs::status(file).permissions(), fs::perms::owner_read | fs::perms::owner_write);
  EXPECT_TRUE(fs::exists(copy));
}

TEST_F(Restoring, IsRefusedWhileADaemonHasTheStore) {
  const auto daemon = LockFile::take(lock_of_store(file), "the store");
  ASSERT_TRUE(daemon);
  EXPECT_THAT(why_not(copy), testing::AllOf(HasSubstr("is in use by"), HasSubstr("stop the daemon first")));
  EXPECT_EQ(points_in(open(file)), 11U);
}

TEST_F(Restoring, LeavesTheStoreWhereTheBackupCannotBeUsed) {
  const fs::path other = folder.path() / "other.db";
  std::ofstream{other} << std::string(5000, 'x');
  EXPECT_THAT(why_not(other), HasSubstr("not a database"));
  const auto size = fs::file_size(copy);
  std::fstream bytes{copy, std::ios::in | std::ios::out | std::ios::binary};
  bytes.seekp(static_cast<std::streamoff>(size / 2));
  bytes << std::string(size / 4, '\x5a');
  bytes.close();
  EXPECT_NE(why_not(copy), "");
  const std::string none = folder.path() / "none.db";
  EXPECT_THAT(why_not(none), testing::EndsWith(none + ": there is no such file"));
  EXPECT_EQ(points_in(open(file)), 11U);
  EXPECT_THAT(names(), testing::Each(testing::Not(HasSubstr("restored"))));
}

TEST_F(Restoring, ReplacesAStoreThatCannotBeReadAndKeepsThatToo) {
  std::ofstream{file, std::ios::trunc} << std::string(5000, 'x');
  std::ofstream{file.string() + "-wal"} << "what was in its log";
  const auto aside = restore_store(copy, file, "now");
  ASSERT_TRUE(aside) << aside.error();
  EXPECT_EQ(points_in(open(file)), 10U);
  EXPECT_EQ(fs::file_size(*aside), 5'000U);
  EXPECT_TRUE(fs::exists(aside->string() + "-wal"));
  EXPECT_GT(open(file).begin_events(10).value(), 1'000'000'000U) << "whatever numbers that has given";
}

TEST_F(Restoring, IsDoneByTheFoldersOwnerWhomRootGivesNothingElse) {
  if (::geteuid() != 0) return;  // only root could
  const TempFolder roots;
  const fs::path secret = roots.write("secret", "of root");
  ASSERT_EQ(::chmod(secret.c_str(), 0600), 0);
  constexpr uid_t kNobody = 65534;
  const fs::path backup = roots.path() / "backup.db";
  fs::rename(copy, backup);
  ASSERT_EQ(::chmod(backup.c_str(), 0600), 0);
  for (const auto& each : fs::directory_iterator{folder.path()})
    ASSERT_EQ(::chown(each.path().c_str(), kNobody, kNobody), 0);
  ASSERT_EQ(::chown(folder.path().c_str(), kNobody, kNobody), 0);
  // What the daemon's user may have put there for root to fall over.
  for (const char* const link : {".restored", ".restored.part", ".lock"})
    fs::create_symlink(secret, file.string() + link);
  const auto refused = restore_store(backup, file, "now");
  ASSERT_FALSE(refused) << "the lock is no file";
  fs::remove(file.string() + ".lock");
  const auto aside = restore_store(backup, file, "now");
  ASSERT_TRUE(aside) << aside.error();
  EXPECT_EQ(::geteuid(), 0U);
  struct stat found {};
  ASSERT_EQ(::lstat(secret.c_str(), &found), 0);
  EXPECT_EQ(found.st_uid, 0U);
  EXPECT_EQ(fs::file_size(secret), std::string{"of root"}.size());
  for (const auto& each : fs::directory_iterator{folder.path()}) {
    ASSERT_EQ(::lstat(each.path().c_str(), &found), 0);
    EXPECT_TRUE(found.st_uid == kNobody || S_ISLNK(found.st_mode)) << each.path();
  }
  EXPECT_EQ(points_in(open(file)), 10U);
}

TEST_F(StoreFiles, AStoreWithTwoNamesIsRefused) {
  filled(1);
  fs::create_hard_link(file, folder.path() / "other.db");
  const auto opened = Store::open(file);
  ASSERT_FALSE(opened);
  EXPECT_THAT(opened.error().detail, HasSubstr("has 2 names (hard links)"));
}

TEST_F(StoreFiles, AStoreIsClosedToOthers) {
  filled(3);
  fs::permissions(file, fs::perms::others_read | fs::perms::group_read, fs::perm_options::add);
  EXPECT_EQ(points_in(open(file)), 3U);
  EXPECT_EQ(fs::status(file).permissions() & fs::perms::others_all, fs::perms::none);
}

TEST_F(Restoring, MakesAStoreWhereThereIsNone) {
  fs::remove(file);
  const auto aside = restore_store(copy, file, "now");
  ASSERT_TRUE(aside) << aside.error();
  EXPECT_EQ(*aside, "");
  EXPECT_EQ(points_in(open(file)), 10U);
}

TEST(CorrectionMark, LiesInTheStoresFolderFromTheFirstCorrectionOn) {
  const TempFolder folder;
  const std::filesystem::path store = folder.path() / "cell.store";
  EXPECT_FALSE(may_have_corrected(store));
  ASSERT_TRUE(keep_corrected(store));
  ASSERT_TRUE(keep_corrected(store)) << "once more";
  EXPECT_TRUE(may_have_corrected(store));
  const auto refused = keep_corrected(folder.path() / "nowhere" / "cell.store");
  ASSERT_FALSE(refused);
  EXPECT_THAT(refused.error().detail, HasSubstr("cell.store.corrected: cannot be written: No such file"));
}

}  // namespace
}  // namespace truepose::daemon
