// Recordings of the simulated cell, of which something is altered, missing, or cut off.
#include "daemon/replay/driver_replay.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>

#include "config/text_file.hpp"
#include "tests/daemon/altered_recording.hpp"

namespace truepose::daemon {
namespace {

using recording::Kind;
using recording::Record;
using recording::Wire;
using testing::AllOf;
using testing::Contains;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Key;
using testing::StartsWith;

using Records = std::vector<Record>;

/// Of one driver.
Records recorded(const std::string& name, const std::string& driver) {
  const auto recording = recording::Recording::read(
      config::read_bytes(TRUEPOSE_SOURCE_DIR "/tests/recordings/" + name + ".recording"));
  Records records = records_of(recording.value());
  const bool tracker = driver == "tracker";
  std::erase_if(records, [tracker](const Record& record) {
    return record.wire == Wire::Rsi || record.wire == Wire::Daemon ||
           (record.wire == Wire::Tracker) != tracker;
  });
  return records;
}

DriverReport replayed(const Records& records) {
  DriverReplay replay{"driver"};
  for (const Record& record : records) replay.take(record);
  return replay.report();
}

/// The record of this kind before which there are so many others.
Record& nth(Records& records, Kind kind, std::size_t number) {
  for (Record& record : records)
    if (record.kind == kind && number-- == 0) return record;
  throw std::out_of_range{"fewer records"};
}

std::uint64_t not_judged(const DriverReport& report) {
  std::uint64_t calls = 0;
  for (const auto& [why, of] : report.not_judged) calls += of;
  return calls;
}

struct AReplayedDriver : testing::TestWithParam<std::pair<const char*, const char*>> {
  Records records = recorded(GetParam().first, GetParam().second);
};

TEST_P(AReplayedDriver, DoesWhatTheRecordedOneDid) {
  const DriverReport report = replayed(records);
  EXPECT_EQ(report.different, 0U) << report.first_different->text;
  EXPECT_EQ(report.same + not_judged(report), report.calls);
  EXPECT_GT(report.same, 10U);
}

// A ring begins anywhere, and a recording may be cut off anywhere.
TEST_P(AReplayedDriver, IsJudgedFromWhereItIsKnownToWhereTheRecordingEnds) {
  const std::size_t step = records.size() / 12 + 1;
  for (std::size_t cut = 1; cut < records.size(); cut += step) {
    const auto middle = records.begin() + static_cast<std::ptrdiff_t>(cut);
    const DriverReport from_there = replayed({middle, records.end()});
    EXPECT_EQ(from_there.different, 0U) << "from " << cut << ": " << from_there.first_different->text;
    const DriverReport up_to_there = replayed({records.begin(), middle});
    EXPECT_EQ(up_to_there.different, 0U) << "up to " << cut << ": " << up_to_there.first_different->text;
    EXPECT_EQ(up_to_there.same + not_judged(up_to_there), up_to_there.calls);
  }
}

TEST_P(AReplayedDriver, IsFoundToSendOtherBytes) {
  Record& sent = nth(records, Kind::Sent, 5);
  sent.bytes[sent.bytes.size() / 2] ^= 1;
  const DriverReport report = replayed(records);
  EXPECT_GE(report.different, 1U);
  ASSERT_TRUE(report.first_different);
  EXPECT_EQ(report.first_different->time_ns, sent.time_ns);
  EXPECT_THAT(report.first_different->text, AllOf(HasSubstr(": recorded: sent "), HasSubstr("; now: sent ")));
}

TEST_P(AReplayedDriver, IsFoundToSendMore) {
  const Record& sent = nth(records, Kind::Sent, 5);
  records.erase(records.begin() + (&sent - records.data()));
  EXPECT_GE(replayed(records).different, 1U);
}

TEST_P(AReplayedDriver, IsFoundToSendLess) {
  const auto at = records.begin() + (&nth(records, Kind::Sent, 5) - records.data());
  records.insert(at, *at);
  EXPECT_GE(replayed(records).different, 1U);
}

TEST_P(AReplayedDriver, IsFoundToAnswerOtherwise) {
  Record& outcome = nth(records, Kind::Outcome, 2);
  const std::uint64_t call = read_outcome(outcome.bytes)->call;
  outcome.bytes = R"({"call":)" + std::to_string(call) + R"(,"failure":{"fault":"timeout","detail":"late"}})";
  const DriverReport report = replayed(records);
  EXPECT_GE(report.different, 1U);
  EXPECT_THAT(report.first_different->text, HasSubstr("recorded: " + outcome.bytes + "; now: "));
}

TEST_P(AReplayedDriver, IsFoundNotToCloseAConnection) {
  Record& received = nth(records, Kind::Received, 4);
  const auto at = records.begin() + (&received - records.data());
  records.insert(at + 1, {.time_ns = received.time_ns, .wire = received.wire, .kind = Kind::Closed});
  EXPECT_GE(replayed(records).different, 1U);
}

TEST_P(AReplayedDriver, IsNotJudgedWhereRecordsAreMissing) {
  const std::size_t half = records.size() / 2;
  DriverReplay replay{"driver"};
  for (std::size_t i = 0; i < records.size(); ++i) {
    if (i >= half && i < half + 3) continue;
    if (i == half + 3) replay.miss();
    replay.take(records[i]);
  }
  const DriverReport report = replay.report();
  EXPECT_EQ(report.different, 0U) << report.first_different->text;
  EXPECT_EQ(report.same + not_judged(report), report.calls);
}

TEST_P(AReplayedDriver, WhoseCallsCannotBeReadIsJudgedUpToThere) {
  nth(records, Kind::Call, 6).bytes = "{}";
  const DriverReport report = replayed(records);
  EXPECT_EQ(report.different, 0U) << report.first_different->text;
  EXPECT_GE(report.same, 1U);
}

INSTANTIATE_TEST_SUITE_P(Of, AReplayedDriver,
                         testing::Values(std::pair{"eki-drop", "robot"}, std::pair{"beam-break", "tracker"},
                                         std::pair{"tracker-restart", "tracker"},
                                         std::pair{"bridge-restart", "tracker"}),
                         [](const auto& of) {
                           std::string name = std::string{of.param.second} + "_" + of.param.first;
                           std::ranges::replace(name, '-', '_');
                           return name;
                         });

TEST(AReplayedDriverAfterADifference, BeginsAnewWithTheNextConnection) {
  Records records = recorded("tracker-restart", "tracker");
  Record& sent = nth(records, Kind::Sent, 5);
  sent.bytes[8] ^= 1;
  const DriverReport report = replayed(records);
  EXPECT_EQ(report.different, 1U);
  EXPECT_GT(report.same, 10U);
  EXPECT_THAT(report.not_judged, Contains(Key(StartsWith("made after a difference"))));
}

TEST(ADriverOfBefore, HasNoCallsInARecordingOfVersion1) {
  const DriverReport report = replayed(recorded("version-1", "robot"));
  EXPECT_EQ(report.calls, 0U);
  EXPECT_THAT(report.not_judged, IsEmpty());
}

}  // namespace
}  // namespace truepose::daemon
