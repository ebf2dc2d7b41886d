#include <gmock/gmock.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include <csignal>
#include <filesystem>
#include <string>

#include "tests/daemon/corrected_stream.hpp"

namespace truepose::daemon {
namespace {

using testing::HasSubstr;

/// A page under another name for each test.
class ARestartedStream : public testing::Test {
 protected:
  ARestartedStream()
      : file_{std::filesystem::path{testing::TempDir()} /
              ("stream-" + std::to_string(::getpid()) + "-" +
               testing::UnitTest::GetInstance()->current_test_info()->name())},
        memory_{StreamMemory::open(file_).value()} {}
  ~ARestartedStream() override { std::filesystem::remove(file_); }

  /// A new process takes the place of the rig's.
  void restart(StreamRig& rig, StreamMemory* memory) {
    rig.cycle = StreamCycle::create(nominal_arm(), ethernet_config(), stream_options(), memory).value();
  }

  std::filesystem::path file_;
  std::unique_ptr<StreamMemory> memory_;
};

TEST_F(ARestartedStream, GoesOnFromTheCorrectionThatTheProcessBeforeItLeft) {
  StreamRig rig;
  restart(rig, memory_.get());
  correct(rig);
  const JointVector before = rig.applied;
  memory_ = StreamMemory::open(file_).value();
  for (int down = 0; down < 16; ++down) rig.tick({.datagram_lost = true});  // 65 ms
  restart(rig, memory_.get());
  rig.tick();
  EXPECT_EQ(rig.applied, before) << "held in the first cycle";
  EXPECT_EQ(rig.state(), StreamState::RampingOut) << "nobody has started the stream of this process";
  rig.ticks(2 * kRampCycles);
  EXPECT_TRUE(rig.applied.isZero(0));
}

TEST_F(ARestartedStream, CountsNoReplyToWhatTheProcessBeforeItAnswered) {
  StreamRig rig;
  restart(rig, memory_.get());
  correct(rig);
  const std::string answered = rig.datagram();
  ASSERT_NE(rig.send(answered), "") << "by the process before";
  memory_ = StreamMemory::open(file_).value();
  restart(rig, memory_.get());
  EXPECT_EQ(rig.send(answered), "");
  EXPECT_EQ(rig.status().counters.replies(), 0u);
  EXPECT_EQ(rig.status().counters.wrong_ipoc, 1u);
  rig.tick();
  EXPECT_EQ(rig.status().counters.replies(), 1u);
}

TEST_F(ARestartedStream, AdoptsWhatIsInForceWhereNothingWasLeftAndTheArmStands) {
  StreamRig rig;
  correct(rig);
  restart(rig, nullptr);
  rig.ticks(10);
  EXPECT_GT(rig.largest_applied_deg(), 1) << "not answered";
  EXPECT_EQ(rig.state(), StreamState::Unproven);
  EXPECT_THAT(reason(rig.status()), HasSubstr("as soon as the arm stands"));
  rig.ticks(2 * kRampCycles);
  EXPECT_TRUE(rig.applied.isZero(0)) << "ramped out, a step at a time";
}

TEST_F(ARestartedStream, StaysSilentWhileTheArmMovesAndNothingIsKnown) {
  StreamRig rig;
  correct(rig);
  restart(rig, nullptr);
  for (int i = 0; i < 100; ++i) {
    rig.q[0] += 0.4 * kRadPerDeg;
    EXPECT_EQ(rig.tick({.datagram_lost = i == 50}), "");
  }
  EXPECT_GT(rig.largest_applied_deg(), 1);
  EXPECT_EQ(rig.status().counters.lost, 1) << "counted although nothing is answered";
}

TEST_F(ARestartedStream, DoesNotBelieveAPageThatIsNotWhole) {
  StreamRig rig;
  restart(rig, memory_.get());
  correct(rig);
  memory_.reset();
  std::filesystem::resize_file(file_, 40);
  memory_ = StreamMemory::open(file_).value();
  EXPECT_FALSE(memory_->last());
}

TEST_F(ARestartedStream, HasRoomForItsPageBeforeItWritesToIt) {
  memory_.reset();
  std::filesystem::remove(file_);
  std::signal(SIGXFSZ, SIG_IGN);
  rlimit before{};
  ::getrlimit(RLIMIT_FSIZE, &before);
  const rlimit full{1, before.rlim_max};
  ::setrlimit(RLIMIT_FSIZE, &full);
  const std::string refused = StreamMemory::open(file_).error().text;
  ::setrlimit(RLIMIT_FSIZE, &before);
  std::signal(SIGXFSZ, SIG_DFL);
  EXPECT_EQ(refused, file_.string() + ": cannot be made as large as a page: File too large");
  memory_ = StreamMemory::open(file_).value();
  struct stat about {};
  ASSERT_EQ(::stat(file_.c_str(), &about), 0);
  EXPECT_GE(about.st_blocks * 512, about.st_size) << "a file with a hole";
}

}  // namespace
}  // namespace truepose::daemon
