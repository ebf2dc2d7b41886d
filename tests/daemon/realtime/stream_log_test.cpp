#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <vector>

#include "daemon/realtime/stream_status.hpp"
#include "tests/daemon/stream_rig.hpp"

namespace truepose::daemon {
namespace {

using namespace std::chrono_literals;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

constexpr drivers::TimePoint t0{};

class StreamLogTest : public testing::Test {
 protected:
  std::vector<std::string> said() { return std::exchange(lines_, {}); }
  /// The log lines of all events of the cycle since the last call.
  std::vector<std::string> said_by(StreamCycle& cycle, drivers::TimePoint now) {
    for (StreamEvent event; cycle.next_event(event);) log_.take(event, now);
    log_.pass(cycle.dropped_events(), now);
    return said();
  }

  StreamLog log_{[this](LogLevel level, const std::string& line) {
    lines_.push_back(std::string{name(level)} + " " + line);
  }};

 private:
  std::vector<std::string> lines_;
};

TEST_F(StreamLogTest, SaysTheFirstOfAKindAtOnceAndAddsUpWhatFollows) {
  const StreamEvent gap{.kind = StreamEventKind::PacketsLost, .ipoc = 400, .value = 3};
  log_.take(gap, t0);
  EXPECT_THAT(said(), ElementsAre("warning stream: 3 cycles lost before IPOC 400"));
  for (int i = 0; i < 1000; ++i) log_.take(gap, t0 + 5s);
  log_.pass(0, t0 + 9s);
  EXPECT_THAT(said(), IsEmpty());
  log_.pass(0, t0 + 10s);
  EXPECT_THAT(said(), ElementsAre("warning stream: 3000 more cycles lost in 1000 gaps in 10 s"));
}

TEST_F(StreamLogTest, KeepsSilenceAfterASumAndSpeaksAtOnceAgainAfterAQuietTime) {
  const StreamEvent late{.kind = StreamEventKind::RepliesLate, .ipoc = 8, .value = 1};
  log_.take(late, t0);
  log_.take(late, t0 + 1s);
  log_.pass(0, t0 + 10s);
  said();
  log_.take(late, t0 + 11s);
  EXPECT_THAT(said(), IsEmpty());
  log_.pass(0, t0 + 20s);
  EXPECT_THAT(said(), ElementsAre("warning stream: 1 more late reply in 10 s"));
  log_.pass(0, t0 + 30s);
  EXPECT_THAT(said(), IsEmpty());
  log_.take(late, t0 + 31s);
  EXPECT_THAT(said(), ElementsAre("warning stream: the controller counted 1 late reply at IPOC 8"));
}

TEST_F(StreamLogTest, NeverKeepsAChangeOfTheStateBack) {
  for (int i = 0; i < 3; ++i) {
    log_.take({.kind = StreamEventKind::StateChanged,
               .state = StreamState::Fault,
               .fault = StreamFault::BoundBroken,
               .ipoc = 12,
               .value = 0},
              t0);
  }
  const auto line = AllOf(HasSubstr("error stream: fault at IPOC 12: "), HasSubstr("acknowledge"));
  EXPECT_THAT(said(), ElementsAre(line, line, line));
}

TEST_F(StreamLogTest, CountsTheEventsForWhichTheRingHadNoRoom) {
  log_.pass(5, t0);
  EXPECT_THAT(said(), ElementsAre("warning stream: 5 events came too fast and were dropped"));
  log_.pass(5, t0 + 1s);
  EXPECT_THAT(said(), IsEmpty());
}

TEST_F(StreamLogTest, LogsTheStoryOfAControllerThatRestarts) {
  StreamRig rig;
  rig.ticks(3);
  EXPECT_THAT(
      said_by(*rig.cycle, t0),
      ElementsAre("info stream: the controller began a session at IPOC 4208167 from 127.0.0.1:40000"));
  rig.cycle->use_model(real_arm(), 1);
  rig.cycle->engage();
  rig.ticks(300);
  EXPECT_THAT(
      said_by(*rig.cycle, t0 + 1s),
      ElementsAre("info stream: another model is in use",
                  "info stream: the correction in effect at the controller is known at IPOC 4208179: at "
                  "most 0.000 deg on an axis",
                  "info stream: ramping in", "info stream: active"));

  rig.restart(100);
  rig.ticks(300);
  EXPECT_THAT(said_by(*rig.cycle, t0 + 20s),
              ElementsAre(HasSubstr("the controller began a session at IPOC 1"),
                          HasSubstr("in effect at the controller is known at IPOC 1"),
                          "info stream: ramping in", "info stream: active"));
}

}  // namespace
}  // namespace truepose::daemon
