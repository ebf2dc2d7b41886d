// The faults between controller and PC that cells meet, each with what truepose doctor then says of RSI and
// daemon: one cause, and the right one. What a firewall drops is in tests/tools/doctor/diagnose_test.cpp.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/udp.hpp>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "tests/await.hpp"
#include "tests/integration/asked_doctor.hpp"
#include "tests/integration/healthy_frame.hpp"
#include "tests/tools/doctor/scripted_controller.hpp"

namespace truepose {
namespace {

namespace json = boost::json;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

const std::string kControllersFile = TRUEPOSE_SOURCE_DIR "/config/kuka/rsi/truepose_rsi_ethernet.xml";

class ACellWithOneFault : public testing::Test {
 protected:
  /// The store of one campaign, which each cell gets a copy of.
  static void SetUpTestSuite() {
    LiveCell cell{{.speedup = 2000}};
    cell.start_daemon();
    const Finished campaign = small_campaign(cell);
    if (campaign.exit_code != 0) throw std::runtime_error{campaign.err};
    cell.daemon().terminate();
    cell.daemon().wait();
    calibrated = std::make_unique<TempFolder>();
    for (const char* end : {"", ".audit", ".audit.head"})
      std::filesystem::copy_file(cell.store_file().string() + end,
                                 calibrated->path() / (std::string{"store"} + end));
  }
  static void TearDownTestSuite() { calibrated.reset(); }

  void begin(LiveCell::Options options = {}) {
    options.speedup = 2000;
    options.patient = true;
    cell.emplace(options);
    for (const char* end : {"", ".audit", ".audit.head"})
      std::filesystem::copy_file(calibrated->path() / (std::string{"store"} + end),
                                 cell->store_file().string() + end);
  }
  void begin_with_ethernet(const std::string& text, const std::string& instead) {
    std::string file = text_of(kControllersFile);
    const std::size_t at = file.find(text);
    if (at == std::string::npos) throw std::runtime_error{"there is no " + text};
    for (std::size_t k = at; k != std::string::npos; k = file.find(text, k + instead.size()))
      file.replace(k, text.size(), instead);
    begin({.scenario = {{kControllersFile, files.write("controller.xml", file)}}});
  }
  /// Its stream runs, or has a fault already.
  void stream() {
    cell->start_daemon();
    ASSERT_EQ(cell->truepose({"connect"}).exit_code, 0);
    cell->truepose({"stream", "start"});
  }
  json::value status() const { return cell->client().call("stream.status", {}).value(); }
  void wait_for_state(const std::string& state) const {
    await("the stream is " + state, [&] { return status().at("state") == json::value(state); });
  }
  void wait_for_cycles(double cycles) const {
    await("so many cycles", [&] { return number(status(), "/cycles") >= cycles; });
  }

  ScriptedController::Frame healthy(int decimals = 4) const {
    return [config = config::load_cell(cell->cell_file()), decimals](std::uint64_t cycle) {
      return wire(healthy_frame(config, cycle), decimals);
    };
  }
  void send(std::uint16_t port, ScriptedController::Frame frame, const std::string& from = "127.0.0.1") {
    controller = std::make_unique<ScriptedController>(port, std::move(frame), from);
  }

  /// What is wrong with RSI and daemon by the doctor, but for the replies that this machine was late with,
  /// and the packets of tests that run at the same time.
  std::vector<std::string> said(const std::string& to_others = "is none of ours") const {
    std::vector<std::string> wrong;
    for (const Said& one : doctor_of(*cell, std::nullopt)) {
      const bool looked_at = one.area == "rsi" || one.area == "daemon";
      const bool of_another_test =
          one.finding.contains("sends RSI packets to") && !one.finding.contains(to_others);
      // A loaded machine is true, and no part of these faults.
      const bool of_slow_machine = one.finding.contains("replies late") ||
                                   one.finding.contains("in time (Delay)") ||
                                   one.finding.contains("did not arrive");
      if (!looked_at || one.level == "ok" || of_another_test || of_slow_machine) continue;
      wrong.push_back(one.level + ": " + one.finding + "; next: " + one.next);
      std::printf("doctor: %s\n", wrong.back().c_str());
    }
    return wrong;
  }

  static inline std::unique_ptr<TempFolder> calibrated;
  TempFolder files;
  std::optional<LiveCell> cell;
  std::unique_ptr<ScriptedController> controller;
};

TEST_F(ACellWithOneFault, PacketsGoElsewhere) {
  if (::geteuid() != 0) GTEST_SKIP() << "root alone sees packets to other ports";
  begin();
  cell->start_daemon();
  const std::uint16_t other = free_udp_port();
  send(other, healthy());
  const std::string target = "127.0.0.1:" + std::to_string(other);
  EXPECT_THAT(said(target),
              ElementsAre(AllOf(HasSubstr("sends RSI packets to " + target), HasSubstr("IP_NUMBER"))));
}

TEST_F(ACellWithOneFault, ThePortIsInUse) {
  begin();
  boost::asio::io_context io;
  using boost::asio::ip::udp;
  const udp::socket holder{io, {boost::asio::ip::address_v4::loopback(), cell->rsi_port()}};
  EXPECT_THAT(said(), ElementsAre(AllOf(HasSubstr("(process " + std::to_string(getpid()) + ")"),
                                        HasSubstr("end that"))));
}

TEST_F(ACellWithOneFault, TheControllerOnlySends) {
  begin_with_ethernet("<ONLYSEND>FALSE", "<ONLYSEND>TRUE");
  stream();
  wait_for_state("holding");
  EXPECT_THAT(said(), ElementsAre(AllOf(HasSubstr("do not follow the correction"),
                                        HasSubstr("only sends (ONLYSEND)"))));
}

TEST_F(ACellWithOneFault, SentypeDiffers) {
  begin_with_ethernet("<SENTYPE>TruePose", "<SENTYPE>ImFree");
  stream();
  wait_for_state("fault");
  EXPECT_THAT(said(), ElementsAre(HasSubstr("another SENTYPE")));
}

TEST_F(ACellWithOneFault, NamesOfElementsDiffer) {
  begin_with_ethernet("AK.A", "AKorr.A");
  stream();
  wait_for_state("holding");
  EXPECT_THAT(said(), ElementsAre(HasSubstr("another name for the correction")));
}

TEST_F(ACellWithOneFault, TheCycleDiffers) {
  begin({.scenario = {{"  cycle_ms: 4", "  cycle_ms: 12"}}});
  stream();
  wait_for_state("fault");
  EXPECT_THAT(said(), ElementsAre(AllOf(HasSubstr("rises by 12"), HasSubstr("stream.cycle_ms"))));
}

TEST_F(ACellWithOneFault, TwoSenders) {
  begin();
  stream();
  wait_for_state("correcting");
  send(cell->rsi_port(), healthy(), "127.0.0.2");
  await("the daemon has refused a datagram", [&] { return status().at("refused").is_string(); });
  EXPECT_THAT(said(), ElementsAre(AllOf(HasSubstr("packets of 127.0.0.2"), HasSubstr("robot.rsi_peer"))));
}

TEST_F(ACellWithOneFault, TheDaemonDoesNotRun) {
  begin();
  send(cell->rsi_port(), healthy());
  EXPECT_THAT(said(), ElementsAre(AllOf(HasSubstr("cannot be reached"), HasSubstr("systemctl start"))));
}

TEST_F(ACellWithOneFault, T1InMidProgram) {
  begin();
  stream();
  wait_for_state("correcting");
  cell->steer({{"kind", "operating-mode"}, {"mode", "T1"}});
  wait_for_state("holding");
  EXPECT_EQ(status().at_pointer("/robot/mode"), "T1");
  EXPECT_THAT(said(), ElementsAre(HasSubstr("the robot program is stopped")));
}

TEST_F(ACellWithOneFault, PrecisionIs1) {
  begin();
  send(cell->rsi_port(), healthy(1));
  EXPECT_THAT(said(), ElementsAre(HasSubstr("cannot be reached"),
                                  AllOf(HasSubstr("warning"), HasSubstr("Precision 1"))))
      << "no other arm is accused";
}

TEST_F(ACellWithOneFault, HoldonIs0OnTheControllerAlone) {
  begin({.scenario = {{"  cycle_ms: 4", "  hold_on: false\n  cycle_ms: 4"}}});
  stream();
  wait_for_state("correcting");
  EXPECT_THAT(said(), IsEmpty()) << "nothing shows it as long as replies come; truepose kuka lint does";
}

TEST_F(ACellWithOneFault, DatagramsComeTwice) {
  begin({.faults = "[{kind: rsi-duplicate, at_cycle: 10, lasts_cycles: 500}]"});
  stream();
  wait_for_state("correcting");
  wait_for_cycles(600);
  EXPECT_THAT(said(), IsEmpty()) << "the stream goes on";
  EXPECT_GT(number(status(), "/duplicate"), 100);
}

TEST_F(ACellWithOneFault, DelayIsMissing) {
  begin_with_ethernet("<ELEMENT TAG=\"DEF_Delay\" TYPE=\"LONG\" INDX=\"INTERNAL\"/>", "");
  stream();
  wait_for_state("fault");
  EXPECT_THAT(said(), ElementsAre(AllOf(HasSubstr("have no Delay"), HasSubstr("load that one there"))));
}

TEST_F(ACellWithOneFault, TheCorrectionIsNotApplied) {
  begin({.scenario = {{"  cycle_ms: 4", "  ignores_correction: true\n  cycle_ms: 4"}}});
  stream();
  wait_for_state("holding");
  EXPECT_THAT(said(), ElementsAre(HasSubstr("do not follow the correction")));
}

TEST_F(ACellWithOneFault, AxiscorrClamps) {
  begin({.scenario = {{"axis_corr_limit_deg: 5", "axis_corr_limit_deg: 0.3"}}});
  stream();
  wait_for_state("holding");
  await("what the axes show is known",
        [&] { return std::string{status().at("reason").as_string()}.contains("clamps the correction"); });
  EXPECT_THAT(said(), ElementsAre(AllOf(HasSubstr("the controller clamps the correction: A"),
                                        HasSubstr("stands at 0.30 deg"), HasSubstr("AXISCORR"))));
}

}  // namespace
}  // namespace truepose
