#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <boost/json/parse.hpp>

#include "tests/daemon/altered_recording.hpp"
#include "tests/process.hpp"
#include "tests/temp_folder.hpp"

namespace truepose {
namespace {

namespace json = boost::json;
using testing::AllOf;
using testing::ContainsRegex;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

const std::string kIgnored = TRUEPOSE_SOURCE_DIR "/tests/recordings/rsi-ignore.recording";
const std::string kDropped = TRUEPOSE_SOURCE_DIR "/tests/recordings/eki-drop.recording";
const std::string kVersion1 = TRUEPOSE_SOURCE_DIR "/tests/recordings/version-1.recording";

Finished replay(std::vector<std::string> arguments) {
  arguments.insert(arguments.begin(), "replay");
  return run_program("truepose", arguments);
}

TEST(TheReplayCommand, SaysWhatARecordingIsAndWhatBecameOfIt) {
  const Finished replayed = replay({kIgnored});
  EXPECT_EQ(replayed.exit_code, 0) << replayed.err;
  EXPECT_THAT(replayed.out,
              AllOf(HasSubstr("cell     demo"), HasSubstr("#KR210R2700_2 C4 FLR, serial 210001, KSS 8.6.11"),
                    ContainsRegex("rsi +711 +711 +0 +1"), ContainsRegex("tracker +68 +68 +0 +1"),
                    HasSubstr("711 of 711 compared, 0 different"),
                    ContainsRegex("stream now at -1\\.[0-9]+ s: frozen at IPOC")));
  EXPECT_THAT(replayed.err, IsEmpty());
}

TEST(TheReplayCommand, PrintsOneJsonDocument) {
  const Finished replayed = replay({kIgnored, "--json", "--wire", "rsi"});
  EXPECT_EQ(replayed.exit_code, 0) << replayed.err;
  const json::value report = json::parse(replayed.out);
  EXPECT_EQ(report.at("wires").as_array().size(), 1U) << "this wire alone";
  EXPECT_EQ(report.at_pointer("/stream/counters/held"), 310);
  EXPECT_EQ(report.at("same"), true);
  EXPECT_THAT(std::string{report.at_pointer("/stream/faults/0/text").as_string()},
              HasSubstr("do not follow"));
}

TEST(TheReplayCommand, AsksTheDriversAgainWhatTheyWereAsked) {
  const Finished replayed = replay({kDropped});
  EXPECT_EQ(replayed.exit_code, 0) << replayed.err;
  EXPECT_THAT(replayed.out,
              AllOf(ContainsRegex("DRIVER +CALLS +SAME +DIFFERENT +NOT JUDGED"),
                    ContainsRegex("robot +155 +155 +0 +0"), ContainsRegex("tracker +58 +58 +0 +0")));
  const json::value of_robot = json::parse(replay({kDropped, "--json", "--wire", "robot"}).out);
  EXPECT_EQ(of_robot.at("wires").as_array().size(), 0U);
  EXPECT_EQ(of_robot.at("drivers").as_array().size(), 1U) << "this driver alone";
  EXPECT_EQ(of_robot.at_pointer("/drivers/0/same"), 155);
  EXPECT_THAT(replay({kVersion1}).out, HasSubstr("their decoders alone read the frames"));
}

TEST(TheReplayCommand, EndsWith1WhereADriverDoesSomethingElse) {
  const auto recording = recording::Recording::read(text_of(kDropped)).value();
  std::vector<recording::Record> records = daemon::records_of(recording);
  const auto sent = std::ranges::find_if(records, [](const recording::Record& record) {
    return record.kind == recording::Kind::Sent && record.wire == recording::Wire::EkiLink;
  });
  ASSERT_NE(sent, records.end());
  sent->bytes.insert(sent->bytes.find("Vel"), "Speed=\"1\" ");
  const TempFolder folder;
  const auto file = folder.write("altered.recording", daemon::bytes_of(recording.header(), records));
  const Finished replayed = replay({file});
  EXPECT_EQ(replayed.exit_code, 1);
  EXPECT_THAT(replayed.out,
              AllOf(ContainsRegex("robot different first at -[0-9.]+ s: eki-link: recorded: sent "
                                  "<Cmd [^;]*Speed=[^;]*; now: sent <Cmd "),
                    ContainsRegex("Not judged: robot: [0-9]+ made after a difference")));
  const json::value report = json::parse(replay({file, "--json"}).out);
  EXPECT_EQ(report.at("same"), false);
  EXPECT_EQ(report.at_pointer("/drivers/0/different"), 1);
}

TEST(TheReplayCommand, ListsRecordsWithTextAsItIsAndOtherBytesInHexadecimal) {
  const Finished link = replay({kIgnored, "--list", "--wire", "eki-link"});
  EXPECT_EQ(link.exit_code, 0) << link.err;
  EXPECT_THAT(link.out, AllOf(HasSubstr("eki-link   connected   CellLink at 127.0.0.1:"),
                              HasSubstr("<Hello "), Not(HasSubstr("tracker"))));
  const Finished tracker = replay({kIgnored, "--list", "--wire", "tracker"});
  EXPECT_THAT(tracker.out, ContainsRegex("tracker +sent +0[0-9a-f]000000"));
}

TEST(TheReplayCommand, ReadsAFileThatWasCutOffUpToThereAndSaysSo) {
  const TempFolder folder;
  const std::string whole = text_of(kIgnored);
  const auto cut = folder.write("cut.recording", whole.substr(0, whole.size() - 4));
  const Finished replayed = replay({cut, "--json"});
  EXPECT_EQ(replayed.exit_code, 0);
  EXPECT_THAT(replayed.err, HasSubstr("cut.recording: damaged, or cut off, at byte "));
  EXPECT_EQ(json::parse(replayed.out).at_pointer("/stream/different"), 0);
}

TEST(TheReplayCommand, RefusesWhatIsNoRecording) {
  const TempFolder folder;
  const Finished refused = replay({folder.write("x.recording", "truepose")});
  EXPECT_EQ(refused.exit_code, 2);
  EXPECT_THAT(refused.err, HasSubstr("x.recording: is no recording of truepose"));
  EXPECT_EQ(replay({"none.recording"}).exit_code, 2);
  EXPECT_EQ(replay({kIgnored, "--wire", "usb"}).exit_code, 2);
}

}  // namespace
}  // namespace truepose
