#include "daemon/replay/replay.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>

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
  RecordedLife life{Ring::kLeastBytes};
  live_long(life);
  const recording::Recording recording = life.saved();
  int started = 0;
  recording.for_each([&](const Record& record) { started += record.kind == Kind::Started; });
  ASSERT_EQ(started, 0);
  const ReplayReport report = replayed(recording);
  EXPECT_THAT(report.stream.not_compared, ElementsAre(HasSubstr("begins within the life of a stream")));
  EXPECT_EQ(report.stream.different, 0U) << report.stream.first_different->text;
  EXPECT_GT(report.stream.compared + 800, report.wires.front().frames) << "all but two seconds or so";
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

TEST(AReplay, TellsADeviceFrameThatWasAcceptedWhenItWasRecorded) {
  const std::string bad = "<Ack Id=\"x\"/>", good = "<Ack Id=\"1\" State=\"3\" Err=\"0\"></Ack>";
  const auto report_of = [](const std::vector<std::pair<Kind, std::string>>& said) {
    RecordedLife life;
    for (const auto& [kind, bytes] : said) life.recorder.tell(Wire::EkiLink, kind, bytes);
    return replayed(life.saved());
  };
  const ReplayReport ended = report_of({{Kind::Connected, ""}, {Kind::Received, bad}, {Kind::Closed, ""}});
  EXPECT_EQ(ended.wires.back().rejected, 1U);
  EXPECT_THAT(ended.wires.back().first_rejected->text, HasSubstr("Ack"));
  EXPECT_TRUE(ended.same()) << "the driver ended the connection then, too";

  const ReplayReport went_on =
      report_of({{Kind::Connected, ""}, {Kind::Received, bad}, {Kind::Received, good}});
  EXPECT_TRUE(went_on.wires.back().regression);
  EXPECT_FALSE(went_on.same());

  const ReplayReport within = report_of({{Kind::Received, "1\"/>" + bad}, {Kind::Received, good}});
  EXPECT_TRUE(within.same()) << "a recording may begin within a document";
}

// ---- The recordings of the simulated cell's misbehaviour

struct Verdict {
  std::string fault;                              ///< of the stream, as it begins; empty: none
  std::map<std::string, std::uint64_t> counters;  ///< of the stream
  std::uint64_t sessions = 1;                     ///< of RSI
  std::uint64_t robot = 1, tracker = 1;           ///< connections
  /// Of the drivers; 0: the recording is of version 1, which has none.
  std::uint64_t robot_calls = 0, tracker_calls = 0;
  std::uint64_t rejected = 0;  ///< frames of RSI
};

// They are made by
// TRUEPOSE_RECORDINGS=tests/recordings build/release/tests/integration_test
// --gtest_filter='*ARecording.IsMade*' in real time: one that is made anew has other numbers, which `truepose
// replay` says.
const std::map<std::string, Verdict> kVerdicts{
    {"beam-break", {.sessions = 0, .robot_calls = 192, .tracker_calls = 78}},
    {"bridge-beam-break", {.sessions = 0, .robot_calls = 192, .tracker_calls = 78}},
    {"bridge-busy", {.sessions = 0, .robot_calls = 169, .tracker_calls = 65}},
    {"bridge-restart", {.sessions = 0, .tracker = 4, .robot_calls = 151, .tracker_calls = 67}},
    {"bridge-silent", {.sessions = 0, .tracker = 7, .robot_calls = 172, .tracker_calls = 72}},
    {"campaign-controller-restart", {.sessions = 0, .robot = 4, .robot_calls = 166, .tracker_calls = 59}},
    {"campaign-emergency-stop", {.sessions = 0, .robot_calls = 160, .tracker_calls = 59}},
    {"campaign-program-stop", {.sessions = 0, .robot_calls = 160, .tracker_calls = 59}},
    {"controller-restart",
     {.counters = {{"answered", 112}, {"datagrams", 123}, {"unconfirmed", 11}},
      .robot_calls = 6,
      .tracker_calls = 4}},
    {"eki-drop", {.sessions = 0, .robot = 4, .robot_calls = 155, .tracker_calls = 58}},
    {"emergency-stop",
     {.counters = {{"answered", 102}, {"datagrams", 230}, {"unconfirmed", 17}},
      .robot_calls = 5,
      .tracker_calls = 3}},
    {"gate-open", {.sessions = 0, .robot_calls = 160, .tracker_calls = 59}},
    {"operating-mode", {.sessions = 0, .robot_calls = 160, .tracker_calls = 59}},
    {"override", {.sessions = 0, .robot_calls = 141, .tracker_calls = 58}},
    {"program-reset", {.sessions = 0, .robot = 4, .robot_calls = 159, .tracker_calls = 58}},
    {"program-select", {.sessions = 0, .robot = 5, .robot_calls = 167, .tracker_calls = 58}},
    {"program-stop",
     {.counters = {{"answered", 190}, {"datagrams", 232}, {"unconfirmed", 17}},
      .robot_calls = 5,
      .tracker_calls = 3}},
    {"rsi-drop",
     {.counters = {{"answered", 294}, {"datagrams", 312}, {"lost", 30}, {"unconfirmed", 18}},
      .robot_calls = 6,
      .tracker_calls = 4}},
    {"rsi-duplicate",
     {.counters = {{"answered", 259}, {"datagrams", 318}, {"duplicate", 50}, {"unconfirmed", 9}},
      .robot_calls = 6,
      .tracker_calls = 4}},
    {"rsi-corrupt",
     {.counters =
          {{"answered", 277}, {"datagrams", 313}, {"held", 24}, {"malformed", 20}, {"unconfirmed", 12}},
      .robot_calls = 6,
      .tracker_calls = 4,
      .rejected = 20}},
    {"rsi-ignore",
     {.fault = "the axes do not follow the correction: A4 is",
      .counters = {{"answered", 384}, {"datagrams", 711}, {"held", 310}, {"unconfirmed", 17}},
      .robot_calls = 7,
      .tracker_calls = 4}},
    {"rsi-ipoc",
     {.counters = {{"answered", 240}, {"datagrams", 315}, {"lost", 250}, {"unconfirmed", 75}},
      .robot_calls = 6,
      .tracker_calls = 4}},
    {"rsi-late",
     {.counters = {{"answered", 246}, {"datagrams", 308}, {"held", 50}, {"late", 50}, {"unconfirmed", 12}},
      .robot_calls = 6,
      .tracker_calls = 4}},
    {"rsi-lose-datagrams",
     {.counters = {{"answered", 299}, {"datagrams", 311}, {"lost", 20}, {"unconfirmed", 12}},
      .robot_calls = 6,
      .tracker_calls = 4}},
    {"rsi-lose-replies",
     {.counters = {{"answered", 231}, {"datagrams", 310}, {"held", 70}, {"late", 70}, {"unconfirmed", 9}},
      .robot_calls = 6,
      .tracker_calls = 4}},
    {"rsi-reorder",
     {.counters =
          {{"answered", 276}, {"datagrams", 316}, {"lost", 25}, {"unconfirmed", 15}, {"wrong_ipoc", 25}},
      .robot_calls = 6,
      .tracker_calls = 4}},
    {"rsi-restart",
     {.counters = {{"answered", 247}, {"datagrams", 311}, {"unexpected_sender", 9}, {"unconfirmed", 64}},
      .sessions = 2,
      .robot_calls = 6,
      .tracker_calls = 4}},
    {"rsi-second-sender",
     {.counters = {{"answered", 293}, {"datagrams", 308}, {"unexpected_sender", 10}, {"unconfirmed", 15}},
      .robot_calls = 6,
      .tracker_calls = 4}},
    {"rsi-silence",
     {.counters = {{"answered", 136}, {"datagrams", 149}, {"unconfirmed", 13}},
      .robot_calls = 7,
      .tracker_calls = 5}},
    {"tracker-air", {.sessions = 0, .robot_calls = 149, .tracker_calls = 64}},
    {"tracker-bias", {.sessions = 0, .robot_calls = 139, .tracker_calls = 57}},
    {"tracker-bump", {.sessions = 0, .robot_calls = 139, .tracker_calls = 57}},
    {"tracker-busy", {.sessions = 0, .robot_calls = 169, .tracker_calls = 65}},
    {"tracker-noise", {.sessions = 0, .robot_calls = 144, .tracker_calls = 63}},
    {"tracker-restart", {.sessions = 0, .tracker = 4, .robot_calls = 151, .tracker_calls = 66}},
    {"tracker-silent", {.sessions = 0, .tracker = 7, .robot_calls = 172, .tracker_calls = 72}},
    {"tracker-std", {.sessions = 0, .robot_calls = 144, .tracker_calls = 63}},
    {"tracker-storm", {.sessions = 0, .robot_calls = 139, .tracker_calls = 58}},
    {"tracker-stray", {.sessions = 0, .robot_calls = 139, .tracker_calls = 58}},
    {"version-1", {.counters = {{"answered", 290}, {"datagrams", 306}, {"lost", 30}, {"unconfirmed", 16}}}}};

/// Who recorded may have had another processor.
class AReplayOnAnyProcessor : public example::OnEveryIsa {
 protected:
  void SetUp() override {
    OnEveryIsa::SetUp();
    if (!IsSkipped()) kernels::use(GetParam());
  }
  void TearDown() override { kernels::use(best_); }

 private:
  kernels::Isa best_ = kernels::available(kernels::Isa::Avx512) ? kernels::Isa::Avx512
                       : kernels::available(kernels::Isa::Avx2) ? kernels::Isa::Avx2
                                                                : kernels::Isa::Baseline;
};

TEST_P(AReplayOnAnyProcessor, GivesEveryMisbehaviourItsVerdictAndTheSameReplies) {
  std::size_t files = 0;
  for (const auto& entry : std::filesystem::directory_iterator{TRUEPOSE_SOURCE_DIR "/tests/recordings"}) {
    ++files;
    const std::string name = entry.path().stem();
    SCOPED_TRACE(name);
    const auto known = kVerdicts.find(name);
    ASSERT_NE(known, kVerdicts.end());
    const Verdict& verdict = known->second;
    const auto recording = recording::Recording::read(config::read_bytes(entry.path()));
    ASSERT_TRUE(recording) << recording.error();
    const ReplayReport report = replayed(*recording);
    EXPECT_TRUE(report.same());
    EXPECT_EQ(report.stream.compared, report.stream.datagrams);
    for (const auto& [counter, count] : verdict.counters)
      EXPECT_EQ(report.stream.counters.at(counter), count) << counter;
    std::map<Wire, std::uint64_t> sessions;
    for (const WireReport& wire : report.wires) {
      sessions[wire.wire] = wire.sessions;
      EXPECT_EQ(wire.rejected, wire.wire == Wire::Rsi ? verdict.rejected : 0);
    }
    EXPECT_EQ(sessions[Wire::Rsi], verdict.sessions);
    EXPECT_EQ(sessions[Wire::EkiLink], verdict.robot);
    EXPECT_GE(sessions[Wire::EkiState], verdict.robot);
    EXPECT_EQ(sessions[Wire::Tracker], verdict.tracker);
    std::map<std::string, std::uint64_t> same;
    for (const DriverReport& driver : report.drivers) {
      same[driver.name] = driver.same;
      EXPECT_EQ(driver.calls, driver.same) << driver.name;
    }
    EXPECT_EQ(same["robot"], verdict.robot_calls);
    EXPECT_EQ(same["tracker"], verdict.tracker_calls);
    EXPECT_EQ(report.stream.faults.empty(), verdict.fault.empty());
    const std::string fault = report.stream.faults.empty() ? "" : report.stream.faults.front().text;
    EXPECT_THAT(fault, HasSubstr(verdict.fault));
  }
  EXPECT_EQ(files, kVerdicts.size());
}

INSTANTIATE_TEST_SUITE_P(Isa, AReplayOnAnyProcessor, example::kEveryIsa, example::isa_name);

}  // namespace
}  // namespace truepose::daemon
