#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <boost/json/parse.hpp>

#include "tests/daemon/recorded_life.hpp"
#include "tests/process.hpp"
#include "tests/temp_folder.hpp"

namespace truepose {
namespace {

namespace json = boost::json;
using testing::AllOf;
using testing::HasSubstr;
using testing::IsEmpty;

Finished replay(std::vector<std::string> arguments) {
  arguments.insert(arguments.begin(), "replay");
  return run_program("truepose", arguments);
}

/// Of a stream of 200 cycles, one of which had a packet that could not be read.
class TheReplayCommand : public testing::Test {
 protected:
  TheReplayCommand() {
    daemon::RecordedLife life;
    life.rig.settle();
    life.use_model(1);
    life.rig.cycle->engage();
    life.ticks(100);
    life.tick({.replaced_by = "<Rob><IPOC>12</IPOC>"});
    life.ticks(99);
    life.recorder.tell(recording::Wire::Daemon, recording::Kind::Fault, "E_CELL: the controller is silent");
    recording::Header header = daemon::RecordedLife::header();
    header.product = "0.1.0";
    header.cell = "demo";
    header.reason = "asked for";
    header.robot = {"#KR210R2700_2 C4 FLR", "210001", "KSS 8.6.11"};
    const auto recording = life.saved([](recording::Record&) {}, header);
    bytes_ = daemon::bytes_of(header, daemon::records_of(recording));
    header_ = header;
    records_ = daemon::records_of(recording);
  }

  std::filesystem::path file(const std::string& bytes) { return folder_.write("life.pcapng", bytes); }

  TempFolder folder_;
  std::string bytes_;
  recording::Header header_;
  std::vector<recording::Record> records_;
};

TEST_F(TheReplayCommand, SaysWhatARecordingIsAndWhatBecameOfIt) {
  const Finished replayed = replay({file(bytes_)});
  EXPECT_EQ(replayed.exit_code, 0) << replayed.err;
  EXPECT_THAT(replayed.out,
              AllOf(HasSubstr("cell     demo, truepose 0.1.0"),
                    HasSubstr("#KR210R2700_2 C4 FLR, serial 210001, KSS 8.6.11"),
                    HasSubstr("stream then at "), HasSubstr("E_CELL: the controller is silent"),
                    HasSubstr("packet rejected first at "), HasSubstr(" compared, 0 different")));
  EXPECT_THAT(replayed.err, IsEmpty());
}

TEST_F(TheReplayCommand, EndsWith1WhereAReplyIsAnother) {
  const auto sent = std::ranges::find_if(records_, [](const recording::Record& record) {
    return record.kind == recording::Kind::Sent && !record.bytes.empty();
  });
  ASSERT_NE(sent, records_.end());
  sent->bytes[30] ^= 1;
  const auto altered = file(daemon::bytes_of(header_, records_));
  const Finished replayed = replay({altered});
  EXPECT_EQ(replayed.exit_code, 1);
  EXPECT_THAT(replayed.out, HasSubstr("reply different first at "));
  EXPECT_EQ(json::parse(replay({altered, "--json"}).out).at("same"), false);
}

TEST_F(TheReplayCommand, ReadsAFileThatWasCutOffUpToThereAndSaysSo) {
  const Finished replayed = replay({file(bytes_.substr(0, bytes_.size() - 4)), "--json"});
  EXPECT_EQ(replayed.exit_code, 0);
  EXPECT_THAT(replayed.err, HasSubstr("life.pcapng: damaged, or cut off, at byte "));
  EXPECT_EQ(json::parse(replayed.out).at_pointer("/stream/different"), 0);
}

}  // namespace
}  // namespace truepose
