#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <fstream>

#include "tests/daemon/store_fixture.hpp"

namespace truepose::daemon {
namespace {

using testing::HasSubstr;

class StoreSurvivalTest : public StoreTest {
 protected:
  /// A child that adds points and reports each one that was acknowledged, until `limit` bytes are written.
  struct Child {
    pid_t pid;
    int acknowledged;  // the reading end of a pipe

    Child(const std::filesystem::path& file, rlim_t limit) {
      int ends[2];
      if (pipe(ends) != 0) throw std::runtime_error("pipe");
      pid = fork();
      if (pid == 0) {
        std::signal(SIGXFSZ, SIG_IGN);
        const rlimit bytes{limit, limit};
        setrlimit(RLIMIT_FSIZE, &bytes);
        StoreResult<Store> store = Store::open(file);
        bool good = store && store->begin_campaign(campaign("c1"));
        for (int pose = 0; good; ++pose) {
          good = store->add_point("c1", point(pose)).has_value() && write(ends[1], "+", 1) == 1;
        }
        _exit(1);
      }
      close(ends[1]);
      acknowledged = ends[0];
    }

    /// Waits for the end. @return how many acknowledgements came
    int wait() const {
      int seen = 0;
      for (char c; read(acknowledged, &c, 1) == 1;) ++seen;
      return seen;
    }
  };
};

TEST_F(StoreSurvivalTest, FindsADamagedFileWhenItOpens) {
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

TEST_F(StoreSurvivalTest, KeepsEveryAcknowledgedPointWhereThereIsNoMoreRoom) {
  open();
  const Child child{file_, 300'000};
  const int acknowledged = child.wait();
  waitpid(child.pid, nullptr, 0);
  close(child.acknowledged);
  EXPECT_GT(acknowledged, 10);
  Store store = open();
  EXPECT_GE(static_cast<int>(store.points("c1")->size()), acknowledged);
  EXPECT_TRUE(store.add_point("c1", point(0)));
}

TEST_F(StoreSurvivalTest, SaysThatThereIsNoMoreRoomAndTakesNothingHalf) {
  Store store = open();
  ASSERT_TRUE(store.begin_campaign(campaign("c1")));
  std::signal(SIGXFSZ, SIG_IGN);
  rlimit before{};
  getrlimit(RLIMIT_FSIZE, &before);
  const rlimit tight{200'000, before.rlim_max};
  setrlimit(RLIMIT_FSIZE, &tight);
  int acknowledged = 0;
  StoreResult<void> added;
  for (; acknowledged < 10'000 && (added = store.add_point("c1", point(acknowledged))); ++acknowledged) {
  }
  setrlimit(RLIMIT_FSIZE, &before);
  ASSERT_FALSE(added);
  EXPECT_THAT(added.error().detail, HasSubstr("storing a point of campaign c1: " + file_.string() + ": d"));
  EXPECT_EQ(static_cast<int>(open().points("c1")->size()), acknowledged);
}

}  // namespace
}  // namespace truepose::daemon
