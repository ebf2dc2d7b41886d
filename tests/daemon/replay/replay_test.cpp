#include "daemon/replay/replay.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/kernels/dispatch.hpp"
#include "core/math/random.hpp"
#include "tests/core/on_every_isa.hpp"
#include "tests/daemon/recorded_life.hpp"

namespace truepose::daemon {
namespace {

using recording::Kind;
using recording::Record;
using recording::Wire;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

constexpr int kLives = 20;

ReplayReport replayed(const recording::Recording& recording) {
  auto report = replay(recording);
  EXPECT_TRUE(report) << report.error();
  return report.value_or(ReplayReport{});
}

/// Anything that may happen in a cycle.
void misbehave(RecordedLife& life, Random& random) {
  StreamRig& rig = life.rig;
  switch (random.next() % 400) {
    case 0:
      return rig.cycle->engage();
    case 1:
      return rig.cycle->arm();
    case 2:
      return rig.cycle->disengage();
    case 3:
      rig.cycle->acknowledge();
      return;
    case 4:
      return life.use_model(static_cast<int>(1 + random.next() % 2));
    case 5:
      return rig.cycle->use_no_model();
    case 6:
      return rig.restart(random.next() % 1'000'000);
    case 7:
      return rig.pass(std::chrono::milliseconds{random.next() % 600});
    case 8:
      rig.ipoc += rig.step * (random.next() % 20);
      return;
    default:
      rig.q[static_cast<Eigen::Index>(random.next() % 6)] += 0.02 * kRadPerDeg;
  }
}

Fate fate(Random& random) {
  const std::uint64_t chance = random.next() % 200;
  return {.datagram_lost = chance == 0,
          .reply_lost = chance == 1,
          .rejected = chance == 2,
          .replaced_by = chance == 3 ? "<Rob><IPOC>12</IPOC>" : ""};
}

void live(RecordedLife& life, Random& random, int cycles) {
  for (int i = 0; i < cycles; ++i) {
    misbehave(life, random);
    life.tick(fate(random));
  }
}

TEST(AReplay, GivesTheSameRepliesWhateverHappenedToTheStream) {
  for (std::uint64_t seed = 1; seed <= kLives; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    Random random{seed};
    RecordedLife life;
    live(life, random, 3000);
    const ReplayReport report = replayed(life.saved());
    EXPECT_EQ(report.stream.different, 0U) << report.stream.first_different->text;
    EXPECT_EQ(report.stream.compared, report.stream.datagrams);
    EXPECT_GT(report.stream.compared, 2500U);
    EXPECT_THAT(report.stream.not_compared, IsEmpty());
    const StreamStatus status = life.rig.status();
    EXPECT_EQ(report.stream.counters.at("held"), status.counters.held);
    EXPECT_EQ(report.stream.counters.at("unconfirmed"), status.counters.unconfirmed);
    EXPECT_EQ(report.stream.max_step_deg, status.max_step_deg);
    EXPECT_TRUE(report.same());
  }
}

/// A stream that is at work and of whose beginning the ring knows no more.
void live_long(RecordedLife& life) {
  life.rig.settle();
  life.use_model(1);
  life.rig.cycle->engage();
  for (int i = 0; i < 12'000; ++i) {
    life.rig.q[4] += (i / 500 % 2 == 0 ? 0.02 : -0.02) * kRadPerDeg;
    life.tick();
  }
}

TEST(AReplay, ThatBeginsWithinTheLifeOfAStreamGoesOnFromACheckpoint) {
  RecordedLife life{4 * Ring::kLeastBytes};
  live_long(life);
  const recording::Recording recording = life.saved();
  int started = 0;
  recording.for_each([&](const Record& record) { started += record.kind == Kind::Started; });
  ASSERT_EQ(started, 0);
  const ReplayReport report = replayed(recording);
  EXPECT_THAT(report.stream.not_compared, ElementsAre(HasSubstr("begins within the life of a stream")));
  EXPECT_EQ(report.stream.different, 0U) << report.stream.first_different->text;
  EXPECT_GT(report.stream.compared + 800, report.stream.datagrams) << "all but two seconds or so";
  EXPECT_THAT(report.stream.faults, IsEmpty());
}

TEST(AReplay, ComparesAgainFromACheckpointWhereRecordsAreMissing) {
  RecordedLife life;
  life.rig.settle();
  life.ticks(100);
  life.recorder.tell(Wire::Tracker, Kind::Received, std::string(recording::kMostRecordBytes + 1, 'x'));
  life.recorder.drain();
  life.ticks(600);
  const ReplayReport report = replayed(life.saved());
  EXPECT_EQ(report.dropped, 1U);
  EXPECT_THAT(report.stream.not_compared,
              ElementsAre(HasSubstr("records are missing"), HasSubstr("begins within")));
  EXPECT_EQ(report.stream.different, 0U);
  EXPECT_GT(report.stream.compared, 300U);
}

TEST(AReplay, FindsAReplyThatIsAnother) {
  RecordedLife life;
  life.rig.settle();
  life.ticks(10);
  int number = 0;
  const ReplayReport report = replayed(life.saved([&](Record& record) {
    if (record.kind == Kind::Sent && ++number == 8) record.bytes[30] ^= 1;
  }));
  EXPECT_EQ(report.stream.different, 1U);
  ASSERT_TRUE(report.stream.first_different);
  EXPECT_THAT(report.stream.first_different->text, testing::StartsWith("recorded: <Sen Type="));
  EXPECT_FALSE(report.same());
}

TEST(AReplay, WithoutTheModelComparesWhatItCanAndSaysSo) {
  RecordedLife life;
  life.rig.settle();
  life.ticks(50);
  life.use_model(1);
  life.ticks(50);
  recording::Header header = RecordedLife::header();
  header.models.clear();
  const ReplayReport report = replayed(life.saved({}, header));
  EXPECT_THAT(report.stream.not_compared, ElementsAre(HasSubstr("model 1 is not in the recording")));
  EXPECT_EQ(report.stream.compared, 54U);
  EXPECT_EQ(report.stream.different, 0U);
}

TEST(AReplay, RefusesAHeaderThatMakesNoStream) {
  RecordedLife life;
  recording::Header header = RecordedLife::header();
  header.stream.erase("cycle_ms");
  EXPECT_EQ(replay(life.saved({}, header)).error(), "header: the stream's setting cycle_ms cannot be read");
  header = RecordedLife::header();
  header.ethernet_xml = "";
  EXPECT_THAT(replay(life.saved({}, header)).error(), HasSubstr("header: ethernet_xml: "));
}

/// Who recorded may have had another processor.
class AReplayOnAnyProcessor : public example::OnEveryIsa {
 protected:
  void TearDown() override { kernels::use(best_); }

  kernels::Isa best_ = kernels::available(kernels::Isa::Avx512) ? kernels::Isa::Avx512
                       : kernels::available(kernels::Isa::Avx2) ? kernels::Isa::Avx2
                                                                : kernels::Isa::Baseline;
};

TEST_P(AReplayOnAnyProcessor, GivesTheSameReplies) {
  kernels::use(best_);
  RecordedLife life{32 * Ring::kLeastBytes};
  live_long(life);
  const recording::Recording recording = life.saved();
  kernels::use(GetParam());
  const ReplayReport report = replayed(recording);
  EXPECT_TRUE(report.same()) << report.stream.first_different->text;
  EXPECT_EQ(report.stream.compared, report.stream.datagrams);
}

INSTANTIATE_TEST_SUITE_P(Isa, AReplayOnAnyProcessor, example::kEveryIsa, example::isa_name);

}  // namespace
}  // namespace truepose::daemon
