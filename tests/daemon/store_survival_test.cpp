#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <cstdint>
#include <fstream>
#include <random>

#include "tests/daemon/store_fixture.hpp"

namespace truepose::daemon {
namespace {

using testing::HasSubstr;

class StoreSurvivalTest : public StoreTest {
 protected:
  /// A child that adds points and tells of each one that was acknowledged, until it is killed or `limit`
  /// bytes are written.
  struct Child {
    pid_t pid;
    int acknowledged;  // the reading end of a pipe

    Child(const std::filesystem::path& file, const std::string& id, rlim_t limit) {
      int ends[2];
      if (pipe(ends) != 0) throw std::runtime_error("pipe");
      pid = fork();
      if (pid == 0) {
        std::signal(SIGXFSZ, SIG_IGN);
        const rlimit bytes{limit, limit};
        setrlimit(RLIMIT_FSIZE, &bytes);
        StoreResult<Store> store = Store::open(file);
        bool good = store && store->begin_campaign(campaign(id));
        for (int pose = 0; good; ++pose) {
          good = store->add_point(id, point(pose)).has_value() && write(ends[1], "+", 1) == 1;
        }
        _exit(1);
      }
      close(ends[1]);
      acknowledged = ends[0];
    }

    /// Waits for `count` acknowledgements, or for the end. @return how many came
    int wait_for(int count) const {
      int seen = 0;
      for (char c; seen < count && read(acknowledged, &c, 1) == 1;) ++seen;
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

TEST_F(StoreSurvivalTest, KeepsEveryAcknowledgedPointOfAProcessThatIsKilled) {
  constexpr std::uint64_t kSeed = 20260817;
  SCOPED_TRACE(testing::Message() << "seed " << kSeed);
  std::mt19937_64 random{kSeed};
  open();
  for (int kill_number = 0; kill_number < 20; ++kill_number) {
    const std::string id = std::to_string(kill_number);
    const Child child{file_, id, RLIM_INFINITY};
    int acknowledged = child.wait_for(std::uniform_int_distribution{1, 40}(random));
    usleep(static_cast<useconds_t>(random() % 3000));  // anywhere within a commit
    kill(child.pid, SIGKILL);
    waitpid(child.pid, nullptr, 0);
    acknowledged += child.wait_for(1'000'000);
    close(child.acknowledged);

    Store store = open();  // checks the file
    const auto points = store.points(id);
    ASSERT_TRUE(points);
    ASSERT_GE(static_cast<int>(points->size()), acknowledged);
    ASSERT_LE(static_cast<int>(points->size()), acknowledged + 1);
    for (std::size_t i = 0; i < points->size(); ++i) expect_equal((*points)[i], point(static_cast<int>(i)));
  }
}

TEST_F(StoreSurvivalTest, KeepsEveryAcknowledgedPointWhereThereIsNoMoreRoom) {
  open();
  const Child child{file_, "c1", 300'000};
  const int acknowledged = child.wait_for(1'000'000);
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
