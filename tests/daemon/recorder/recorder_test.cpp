#include "daemon/recorder/recorder.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/allocations.hpp"
#include "tests/daemon/recorded_life.hpp"

namespace truepose::daemon {
namespace {

using recording::Kind;
using recording::Record;
using recording::Wire;
using testing::ElementsAre;
using testing::HasSubstr;

std::vector<Record> records_of(const recording::Recording& recording, Kind kind) {
  std::vector<Record> records;
  recording.for_each([&](const Record& record) {
    if (record.kind == kind) records.push_back(record);
  });
  return records;
}

std::vector<std::string> texts_of(const recording::Recording& recording, Kind kind) {
  std::vector<std::string> texts;
  for (const Record& record : records_of(recording, kind)) texts.push_back(record.bytes);
  return texts;
}

TEST(ARecordedStream, GivesTheRepliesOfItsCycleAndNeverAllocates) {
  RecordedLife life;
  life.use_model(1);
  life.rig.cycle->engage();
  StreamRig alone;
  alone.cycle->use_model(real_arm(), 1);
  alone.cycle->engage();
  for (int i = 0; i < 600; ++i) {
    alone.ipoc += alone.step;
    const std::string datagram = i % 30 == 0 ? std::string{"garbage"} : alone.datagram();
    alone.pass(std::chrono::milliseconds{4});
    life.rig.pass(std::chrono::milliseconds{4});
    EXPECT_EQ(life.rig.send(datagram), alone.send(datagram));
  }
  const std::string datagram = alone.datagram();
  const auto before = allocations();
  for (int i = 0; i < 20'000; ++i) {
    life.rig.in_front->answer({datagram, life.rig.source, {}});
    life.rig.in_front->finish({});
  }
  EXPECT_EQ(allocations(), before) << "also where the queue is full";
  EXPECT_GT(life.recorder.status().dropped, 0U);
}

TEST(ARecordedStream, IsRecordedByteByByteWithItsPeerAndItsCommands) {
  RecordedLife life;
  life.rig.settle();
  life.use_model(1);
  life.rig.cycle->engage();
  const std::string reply = life.rig.tick(), datagram = life.rig.datagram();
  life.rig.cycle->disengage();
  life.tick();
  const auto recording = life.saved();
  EXPECT_THAT(texts_of(recording, Kind::Started), ElementsAre(""));
  EXPECT_THAT(texts_of(recording, Kind::Commands), ElementsAre("off 0 0 0", "on 0 1 1", "off 0 1 1"));
  const auto received = records_of(recording, Kind::Received), sent = records_of(recording, Kind::Sent);
  ASSERT_EQ(received.size(), 6U);
  EXPECT_EQ(received[4].bytes, datagram);
  EXPECT_EQ(received[4].peer, (recording::Endpoint{0x7f000001, 40'000}));
  EXPECT_EQ(sent[4].bytes, reply);
  EXPECT_NE(reply, "");
}

TEST(ARecordedStream, KeepsTenDatagramsOfStrangersASecond) {
  StreamOptions options = stream_options();
  options.peer = 0x7f000001;
  const auto memory = StreamMemory::in_process();
  StreamRig rig{options, ethernet_config(), memory.get()};
  const drivers::VirtualClock clock;
  Recorder recorder{Ring::in_process(Ring::kLeastBytes), clock};
  RecordedStream stream{*rig.cycle, *memory, recorder.exchanges()};
  rig.in_front = &stream;
  for (int i = 0; i < 250; ++i) {
    rig.pass(std::chrono::milliseconds{8});
    rig.send("of a stranger", {0x7f000002, 1});
  }
  const TempFolder folder;
  ASSERT_TRUE(recorder.save({}, folder.path() / "file"));
  const auto recording = recording::Recording::read(config::read_bytes(folder.path() / "file"));
  EXPECT_EQ(records_of(*recording, Kind::Received).size(), 20U);
}

TEST(ARecorder, KeepsWhatEveryWireTells) {
  RecordedLife life;
  const drivers::WireTap link = life.recorder.tap(Wire::EkiLink), tracker = life.recorder.tap(Wire::Tracker);
  link(Kind::Connected, "192.168.0.2:40000 192.168.0.10:54600");
  tracker(Kind::Received, std::string_view{"\0\1", 2});
  link(Kind::Closed, {});
  const auto recording = life.saved();
  EXPECT_THAT(texts_of(recording, Kind::Connected), ElementsAre("192.168.0.2:40000 192.168.0.10:54600"));
  const auto received = records_of(recording, Kind::Received);
  ASSERT_EQ(received.size(), 1U);
  EXPECT_EQ(received[0].wire, Wire::Tracker);
  EXPECT_EQ(received[0].bytes, (std::string{"\0\1", 2}));
  EXPECT_EQ(records_of(recording, Kind::Closed).size(), 1U);
}

TEST(ARecorder, CountsAndRecordsWhatItHadNoRoomFor) {
  RecordedLife life;
  const std::string large(recording::kMostRecordBytes, 'x');
  for (int i = 0; i < 70; ++i) life.recorder.tell(Wire::Tracker, Kind::Received, large);
  life.recorder.drain();
  EXPECT_EQ(life.recorder.status().dropped, 6U) << "of 4 MiB that wait for the disk";
  EXPECT_THAT(texts_of(life.saved(), Kind::Dropped), ElementsAre("6"));
  life.recorder.tell(Wire::Tracker, Kind::Received, "small");
  life.recorder.drain();
  EXPECT_THAT(texts_of(life.saved(), Kind::Dropped), ElementsAre("6")) << "reported once";
}

TEST(ARecorder, TellsHowMuchItHas) {
  RecordedLife life;
  life.ticks(251);
  const Recorder::Status status = life.recorder.status();
  // The first record is of the time zero, at which the rig's stream began.
  EXPECT_EQ(status.lasts, std::chrono::milliseconds{1000 + 251 * 4});
  EXPECT_GT(status.bytes, 1000U);
  EXPECT_EQ(status.dropped, 0U);
}

TEST(ARecorder, ThatCannotWriteSaysWhyAndLeavesNoFile) {
  RecordedLife life;
  const TempFolder folder;
  const auto saved = life.recorder.save({}, folder.path() / "none" / "file");
  ASSERT_FALSE(saved);
  EXPECT_THAT(saved.error(), HasSubstr("none/file: cannot be written"));
}

TEST(StreamSettings, AreReadAgainToTheLastDigitAndNameWhatIsWrong) {
  StreamOptions options = stream_options();
  options.max_step_rad = 0.1 + 0.2;
  options.peer = 0x7f000001;
  options.disarm_after.reset();
  auto settings = settings_of(options);
  const auto again = options_of(settings);
  ASSERT_TRUE(again) << again.error();
  EXPECT_EQ(settings_of(*again), settings);
  EXPECT_EQ(again->max_step_rad, options.max_step_rad);
  EXPECT_EQ(again->disarm_after, std::nullopt);
  EXPECT_EQ(again->peer, options.peer);
  settings["ramp_cycles"] = "many";
  EXPECT_EQ(options_of(settings).error(), "the stream's setting ramp_cycles cannot be read");
  EXPECT_FALSE(options_of({}));
}

}  // namespace
}  // namespace truepose::daemon
