// The wires of a daemon are recorded while the simulated controller loses replies.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <boost/json/parse.hpp>
#include <chrono>
#include <filesystem>
#include <sstream>
#include <string>
#include <vector>

#include "tests/await.hpp"
#include "tests/integration/live_cell.hpp"

namespace truepose {
namespace {

namespace json = boost::json;
using testing::Each;
using testing::HasSubstr;
using testing::IsEmpty;

/// A program that goes a short way, of which little has to be recorded.
const Replacements kSmall{{"- [25, -80, 95, 20, 45, -30]", "- [1, -90, 90, 0, 35, 0]"},
                          {"- [15, -65, 75, -15, 50, 40]", "- [1, -90, 90, 0, 36, 0]"},
                          {"- [-20, -75, 85, -30, 30, 10]", "- [1, -90, 90, 0, 36, 1]"},
                          {"- [-10, -95, 105, 10, 55, -20]", "- [0, -90, 90, 0, 36, 1]"}};

/// Its stream has run for some hundred cycles, of which the replies to some were lost.
class ARecordedCell : public testing::Test {
 protected:
  void SetUp() override {
    cell_.start_daemon();
    const Finished made = small_campaign(cell_);
    ASSERT_EQ(made.exit_code, 0) << made.err;
    // A daemon that has recorded nothing yet.
    cell_.daemon().terminate();
    ASSERT_EQ(cell_.daemon().wait(), 0);
    cell_.start_daemon();
    run({"connect"});
    run({"stream", "start"});
    await("the stream has run for 300 cycles or ended", [&] {
      const json::value status = json::parse(run({"status", "--json"}).out);
      return status.at("state") != "streaming" || number(status, "/stream/cycles") >= 300;
    });
    const Finished saved = run({"recording", "save", "--out", file_});
    ASSERT_EQ(saved.exit_code, 0) << saved.err;
  }

  Finished run(const std::vector<std::string>& command) { return cell_.truepose(command); }

  /// A field of each packet that a filter takes, as Wireshark reads the file.
  std::vector<std::string> fields(const std::string& filter, const std::string& field) const {
    const Finished read =
        run_program("/usr/bin/tshark",
                    {"-r", file_, "-Y", filter, "-T", "fields", "-e", field, "-o", "ip.check_checksum:TRUE",
                     "-o", "udp.check_checksum:TRUE", "-o", "tcp.check_checksum:TRUE"});
    EXPECT_EQ(read.exit_code, 0) << read.err;
    std::vector<std::string> values;
    std::istringstream lines{read.out};
    for (std::string line; std::getline(lines, line);) values.push_back(line);
    return values;
  }

  LiveCell cell_{{.speedup = 2000.0,
                  .faults = "[{kind: rsi-lose-replies, at_cycle: 150, lasts_cycles: 20, every_cycles: 50}]",
                  .scenario = kSmall,
                  .cell = {{"ring_mb: 64", "ring_mb: 4"}, {"ramp_ms: 1000", "ramp_ms: 400"}},
                  .patient = true}};
  TempFolder folder_;
  std::filesystem::path file_ = folder_.path() / "shift.pcapng";
};

TEST_F(ARecordedCell, GivesTheSameRepliesInAReplayAndIsReadByWireshark) {
  const Finished replayed = run_program("truepose", {"replay", file_, "--json"});
  ASSERT_EQ(replayed.exit_code, 0) << replayed.out << replayed.err;
  const json::value report = json::parse(replayed.out);
  EXPECT_EQ(report.at_pointer("/robot/serial"), "210001");
  EXPECT_EQ(report.at("same"), true);
  EXPECT_EQ(report.at("dropped"), 0);
  EXPECT_GE(number(report, "/stream/compared"), 100) << replayed.out;
  EXPECT_EQ(number(report, "/stream/different"), 0);
  EXPECT_GE(number(report, "/stream/counters/late"), 40);

  EXPECT_THAT(
      fields(
          "_ws.malformed || ip.checksum.status == 0 || udp.checksum.status == 0 || tcp.checksum.status == 0",
          "frame.number"),
      IsEmpty());
  EXPECT_THAT(
      fields("tcp.analysis.lost_segment || tcp.analysis.retransmission || tcp.analysis.ack_lost_segment",
             "frame.number"),
      IsEmpty());
  const std::string rsi = std::to_string(cell_.rsi_port());
  EXPECT_GE(
      fields("udp.dstport == " + rsi + " && frame.interface_name == \"rsi\"", "frame.time_epoch").size(),
      300U);
  EXPECT_GE(fields("udp.srcport == " + rsi + " && frame contains \"<Sen\"", "frame.number").size(), 200U);
  EXPECT_THAT(fields("tcp.flags.syn == 1 && tcp.flags.ack == 0", "ip.dst"), Each("127.0.0.1"));
  EXPECT_FALSE(
      fields("frame.interface_name == \"eki-link\" && frame contains \"<Hello\"", "frame.number").empty());
  EXPECT_FALSE(fields("frame.interface_name == \"tracker\" && tcp.len > 0", "frame.number").empty());

  const std::vector<std::string> times = fields("udp", "frame.time_epoch");
  ASSERT_FALSE(times.empty());
  const double now_s =
      std::chrono::duration<double>(std::chrono::system_clock::now().time_since_epoch()).count();
  EXPECT_NEAR(std::stod(times.back()), now_s, 600);
  EXPECT_LE(std::stod(times.front()), std::stod(times.back()));
  EXPECT_THAT(fields("frame.time_relative < -1", "frame.number"), IsEmpty());
}

}  // namespace
}  // namespace truepose
