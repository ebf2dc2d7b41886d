#include <gtest/gtest.h>
#include <unistd.h>

#include "daemon/store/runtime_folder.hpp"
#include "tests/temp_folder.hpp"

namespace truepose::daemon {
namespace {

namespace fs = std::filesystem;

TEST(LockFile, IsHadByOneAtATimeAndNamesTheHolder) {
  const TempFolder folder;
  const fs::path file = folder.path() / "lock";
  {
    const auto first = LockFile::take(file, "the store s");
    ASSERT_TRUE(first);
    const auto second = LockFile::take(file, "the store s");
    ASSERT_FALSE(second);
    EXPECT_TRUE(second.error().may_pass);
    EXPECT_EQ(second.error().text, "the store s is in use by daemon_test (process " +
                                       std::to_string(::getpid()) +
                                       "): a cell has one daemon, and each its own store and folder");
  }
  EXPECT_TRUE(LockFile::take(file, "the store s"));
}

TEST(LockFile, OfAStoreIsTheSameByWhateverWayTheStoreIsNamed) {
  const TempFolder folder;
  const fs::path store = folder.write("cell.sqlite", "");
  fs::create_symlink(store, folder.path() / "link.sqlite");
  EXPECT_EQ(lock_of_store(folder.path() / "link.sqlite"), lock_of_store(store));
  EXPECT_EQ(lock_of_store(folder.path() / "x/../cell.sqlite").filename(), "cell.sqlite.lock");
  EXPECT_EQ(lock_of_store(folder.path() / "new.sqlite").filename(), "new.sqlite.lock");
}

}  // namespace
}  // namespace truepose::daemon
