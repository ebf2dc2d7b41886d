#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <algorithm>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/json/parse.hpp>
#include <filesystem>
#include <iterator>
#include <string>
#include <vector>

#include "config/cell_config.hpp"
#include "proto/rsi/context.hpp"
#include "tests/process.hpp"
#include "tests/simulator_process.hpp"
#include "tests/temp_folder.hpp"

namespace truepose {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

const std::string kData = TRUEPOSE_SOURCE_DIR "/config";

std::ptrdiff_t entries_of(const fs::path& folder) {
  return std::distance(fs::directory_iterator{folder}, fs::directory_iterator{});
}

/// A free TCP port whose next one is free too, as the channels of EKI have them.
std::uint16_t free_pair_of_ports() {
  using boost::asio::ip::tcp;
  boost::asio::io_context io;
  const auto loopback = boost::asio::ip::address_v4::loopback();
  for (;;) {
    const std::uint16_t port = tcp::acceptor{io, {loopback, 0}}.local_endpoint().port();
    tcp::socket next{io, tcp::v4()};
    boost::system::error_code taken;
    next.bind({loopback, static_cast<std::uint16_t>(port + 1)}, taken);
    if (!taken) return port;
  }
}

TEST(CellDemo, MeasuresCalibratesAndReportsASimulatedCellAndEndsItsPrograms) {
  const TempFolder folder;
  const fs::path out = folder.path() / "demo";
  const Finished done =
      run_program("truepose", {"cell", "demo", "--data", kData, "--out", out.string(), "--speedup", "1000"});
  ASSERT_EQ(done.exit_code, 0) << done.err << text_of(out / "daemon.log");
  EXPECT_THAT(done.out, AllOf(HasSubstr("Mean position error"), HasSubstr("Verdict: green"),
                              HasSubstr("report: " + (out / "report.html").string())));
  EXPECT_THAT(text_of(out / "report.html"), HasSubstr("</html>"));
  EXPECT_FALSE(fs::exists(out / "sim.json")) << "the simulator runs on";
  EXPECT_FALSE(fs::exists(out / "run/control.sock")) << "the daemon runs on";
}

TEST(CellDemo, LeavesAFolderAloneThatHasFiles) {
  const TempFolder folder;
  folder.write("report.html", "mine");
  const Finished done =
      run_program("truepose", {"cell", "demo", "--data", kData, "--out", folder.path().string()});
  EXPECT_EQ(done.exit_code, 2);
  EXPECT_THAT(done.err, HasSubstr("is not empty"));
  EXPECT_EQ(entries_of(folder.path()), 1);
}

TEST(CellDemo, NamesThePackageThatIsMissing) {
  const TempFolder folder;
  const fs::path alone = folder.path() / "truepose";
  fs::copy_file(fs::path{TRUEPOSE_BIN_DIR} / "truepose", alone);
  Process demo{folder.path(), alone.string(), {"cell", "demo"}, {"PATH=" + folder.path().string()}};
  EXPECT_EQ(demo.wait(), 2);
  EXPECT_THAT(demo.errors(), HasSubstr("Install the package trueposed"));
}

/// A new cell whose devices are simulated. Its RSI address is one that no test's machine has (RFC 5737).
struct CellNew : testing::Test {
  std::string port(const char* name) const {
    return "127.0.0.1:" + std::to_string(boost::json::parse(ready_).at(name).to_number<int>());
  }
  std::vector<std::string> options(const std::string& name) const {
    return {"cell",         "new",
            "--data",       kData,
            "--out",        out_.string(),
            "--name",       name,
            "--robot",      "kr210_r2700_2",
            "--rsi-peer",   "127.0.0.1",
            "--rsi-listen", "192.0.2.1:49200",
            "--controller", port("eki_port"),
            "--tracker",    port("tracker_port"),
            "--control",    "127.0.0.1:7299",
            "--kss",        "8.6"};
  }
  /// @param input  of a shell: "printf 'a\n' |", "</dev/null"
  Finished by_answers(const std::string& before, const std::string& options = "",
                      const std::string& behind = "") {
    return run_program("/bin/sh", {"-c", before + " " TRUEPOSE_BIN_DIR "/truepose cell new --data " + kData +
                                             " --out " + out_.string() + " " + options + " " + behind});
  }

  TempFolder folder_;
  fs::path out_ = folder_.path();
  TempFolder of_simulator_;
  sim::SimulatorProcess simulator_{
      of_simulator_,
      {"--scenario", kData + "/scenarios/demo.yaml", "--eki-port", std::to_string(free_pair_of_ports()),
       "--tracker-port", "0", "--rsi-target", "127.0.0.1:49152", "--ready-file",
       of_simulator_.path() / "ready.json"}};
  std::string ready_ = simulator_.ready(of_simulator_.path() / "ready.json");
};

TEST_F(CellNew, WritesWhatDaemonAndControllerNeedAndSaysWhatTheCheckSays) {
  const Finished done = run_program("truepose", options("press"));
  EXPECT_THAT(done.out, AllOf(HasSubstr("KR210R2700_2"), HasSubstr("ok       robot: "),
                              HasSubstr("ok       tracker: ")))
      << done.err;
  const config::CellConfig cell = config::load_cell(out_ / "press.yaml");
  EXPECT_EQ(cell.name, "press");
  EXPECT_EQ(config::text(cell.robot.eki_motion), port("eki_port"));
  EXPECT_EQ(config::text(cell.tracker.address), port("tracker_port"));
  EXPECT_EQ(config::text(cell.stream.listen), "192.0.2.1:49200");
  EXPECT_EQ(config::text(cell.control.listen), "127.0.0.1:7299");
  EXPECT_EQ(cell.stream.realtime, config::RealtimePolicy::Require);
  EXPECT_THAT(cell.robot.expect_model, HasSubstr("KR210R2700_2"));
  const auto ethernet = rsi::parse_ethernet_config(text_of(cell.stream.ethernet_xml));
  ASSERT_TRUE(ethernet);
  EXPECT_EQ(ethernet->address, "192.0.2.1");
  EXPECT_EQ(ethernet->port, 49200);
  EXPECT_THAT(text_of(out_ / "press/kuka/EthernetKRL/CellLink.xml"), HasSubstr("<IP>127.0.0.1</IP>"));
  EXPECT_TRUE(fs::exists(out_ / "press/kuka/Program/truepose_motion.src"));
  struct stat token {};
  ASSERT_EQ(::stat((out_ / "press/token").c_str(), &token), 0);
  EXPECT_EQ(token.st_mode & 0007, 0U) << "others can read the token";
}

TEST_F(CellNew, TakesTheArmFromAnArchiveOfItsController) {
  std::vector<std::string> words = options("press");
  const auto robot = std::ranges::find(words, "kr210_r2700_2");
  *robot = TRUEPOSE_SOURCE_DIR "/tests/proto/krl_corpus/kss87";
  const Finished done = run_program("truepose", words);
  EXPECT_THAT(done.out, AllOf(HasSubstr("press/robot.yaml: robot, from the archive"),
                              HasSubstr("ok       robot: "), HasSubstr("ok       tracker: ")))
      << done.err;
  const RobotModel arm = config::load_cell(out_ / "press.yaml").robot.model;
  EXPECT_EQ(arm.name, "KUKA KR210R2700_2 C4 FLR");
  EXPECT_EQ(arm.joints.at(1).a_mm, 330);
  EXPECT_THAT(text_of(out_ / "press/robot.yaml"), HasSubstr("imported from kss87"));
}

TEST_F(CellNew, KeepsTheFilesOfACellThatIsThere) {
  run_program("truepose", options("press"));
  const std::string cell = text_of(out_ / "press.yaml"), token = text_of(out_ / "press/token");
  const Finished again = run_program("truepose", options("press"));
  EXPECT_EQ(again.exit_code, 2);
  EXPECT_THAT(again.err, HasSubstr("press.yaml: is there already"));
  EXPECT_EQ(text_of(out_ / "press.yaml"), cell);
  EXPECT_EQ(text_of(out_ / "press/token"), token);
  EXPECT_EQ(entries_of(out_), 2);
}

TEST_F(CellNew, AsksWithItsDefaultsAndAsksAgainWhatMayNotBe) {
  const std::string address =
      "--rsi-listen 192.0.2.1 --controller " + port("eki_port") + " --tracker " + port("tracker_port");
  const Finished done = by_answers("printf 'two words\\npress\\n\\n\\n\\n\\n' |", address);
  EXPECT_THAT(
      done.out,
      AllOf(HasSubstr("Name of the cell [cell1]: "), HasSubstr("found 'two words'"),
            HasSubstr("[kr210_r2700_2]: "), HasSubstr("Controller, network of RSI: HOST [127.0.0.1]: "),
            HasSubstr("[127.0.0.1:7210]: "), HasSubstr("(KSS) [8.6]: "), Not(HasSubstr("Tracker: HOST"))))
      << done.err;
  EXPECT_EQ(config::text(config::load_cell(out_ / "press.yaml").stream.listen), "192.0.2.1:49152");
}

TEST_F(CellNew, WritesNothingWhereTheInputEndsOrAnAnswerMayNotBe) {
  const Finished ended = by_answers("printf 'press\\n' |");
  EXPECT_EQ(ended.exit_code, 2);
  EXPECT_THAT(ended.err, AllOf(HasSubstr("the input ended before the question 'Robot"),
                               HasSubstr("Nothing was written")));
  const Finished wrong = by_answers("", "--tracker 10.0.0.1:99999", "</dev/null");
  EXPECT_EQ(wrong.exit_code, 2);
  EXPECT_THAT(wrong.err, HasSubstr("Tracker: HOST or HOST:PORT: "));
  const Finished here = by_answers("yes '' |", "--rsi-listen 127.0.0.1 --controller " + port("eki_port"));
  EXPECT_EQ(here.exit_code, 2);
  EXPECT_THAT(here.err, HasSubstr("which the controller sends to"));
  EXPECT_EQ(entries_of(out_), 0);
}

TEST_F(CellNew, MakesItsFolderAndSaysWhyThatCannotBe) {
  out_ = folder_.path() / "cells/line 4";
  const Finished done = run_program("truepose", options("press"));
  EXPECT_THAT(done.out, HasSubstr("ok       robot: ")) << done.err;
  EXPECT_TRUE(fs::exists(out_ / "press.yaml"));
  out_ = folder_.path() / "unused";
  std::vector<std::string> wrong = options("press");
  *std::ranges::find(wrong, "192.0.2.1:49200") = "127.0.0.1";
  EXPECT_EQ(run_program("truepose", wrong).exit_code, 2);
  EXPECT_FALSE(fs::exists(out_));
  out_ = folder_.path() / "cells/line 4/press.yaml";
  const Finished failed = run_program("truepose", options("press"));
  EXPECT_EQ(failed.exit_code, 2);
  EXPECT_THAT(failed.err,
              HasSubstr("press.yaml: cannot be written to (Not a directory). Give another folder"));
}

TEST_F(CellNew, WritesTheFilesOfDevicesThatDoNotAnswerYet) {
  std::vector<std::string> words = options("press");
  simulator_.terminate();
  simulator_.wait();
  const Finished done = run_program("truepose", words);
  EXPECT_EQ(done.exit_code, 3) << done.out;
  EXPECT_THAT(done.err, HasSubstr("robot: "));
  EXPECT_EQ(config::load_cell(out_ / "press.yaml").robot.expect_model, "") << "nothing is known of the arm";
}

}  // namespace
}  // namespace truepose
