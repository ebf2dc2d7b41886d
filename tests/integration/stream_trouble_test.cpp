#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <boost/json/parse.hpp>
#include <boost/json/value.hpp>
#include <chrono>
#include <cstdio>
#include <functional>
#include <utility>

#include "tests/integration/live_cell.hpp"

// What goes wrong between a controller and its stream is said to who starts it, in status, events and log,
// soon and with what to do about it. What needs no socket is in tests/daemon/stream_service_test.cpp.

namespace truepose {
namespace {

namespace json = boost::json;
using testing::AllOf;
using testing::ContainsRegex;
using testing::HasSubstr;
using Words = testing::Matcher<const std::string&>;

const std::string kEthernetFile = TRUEPOSE_SOURCE_DIR "/config/kuka/rsi/truepose_rsi_ethernet.xml";
const std::string kRobotFile = TRUEPOSE_SOURCE_DIR "/config/robots/kr210_r2700_2.yaml";

/// Of the controller, 5 s; a machine that stalls counts none.
constexpr double kSoon_cycles = 1250;

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  if (text.find(from) == std::string::npos) throw std::runtime_error{"there is no " + from};
  for (std::size_t at = 0; (at = text.find(from, at)) != std::string::npos; at += to.size())
    text.replace(at, from.size(), to);
  return text;
}

/// A cell that has a model and is ready to stream, and a client that hears of what happens.
class ATroubledStream : public testing::Test {
 protected:
  /// The test, in real time.
  void experiment(const std::function<void()>& body) {
    in_real_time(body, [this] { return end(); });
  }

  void begin(LiveCell::Options options) {
    options.speedup = 2000;
    options.patient = true;
    cell_.emplace(options);
    cell_->start_daemon();
    const Finished campaign = small_campaign(*cell_);
    if (campaign.exit_code != 0) throw std::runtime_error{campaign.err + cell_->daemon().errors()};
    client_.emplace(cell_->client());
    const json::array topics{"cell", "stream", "fault", "log"};
    if (!client_->call("events.subscribe", {{"topics", topics}})) throw std::runtime_error{"no events"};
    cycles_ = 0;
  }
  /// As `begin`, with a controller that has loaded another configuration than truepose reads.
  void begin_with_ethernet(const std::string& text, const std::string& instead) {
    const auto file = folder_.write("controller.xml", replaced(text_of(kEthernetFile), text, instead));
    begin({.scenario = {{kEthernetFile, file}}});
  }

  Finished start() { return started_ = cell_->truepose({"stream", "start"}); }
  void expect_no_start(const Words& words) {
    const Finished refused = start();
    EXPECT_EQ(refused.exit_code, 3) << refused.out << refused.err;
    EXPECT_THAT(refused.err, words);
    EXPECT_EQ(std::ranges::count(refused.err, '\n'), 1) << refused.err;
  }

  /// Waits for the fault with this code, and looks for the words wherever a person may look.
  void expect_named(const std::string& code, const Words& words) {
    const control::Event fault = wait_for_fault(code);
    EXPECT_THAT(std::string{fault.data.at("text").as_string()}, words);
    expect_logged(code == "E_CELL" ? " error " : " warning ", words);
    EXPECT_THAT(printed({"status"}), AllOf(words, HasSubstr(code)));
    EXPECT_THAT(printed({"stream", "status"}), words);
    const json::value status = json::parse(printed({"status", "--json"}));
    EXPECT_THAT(std::string{status.at_pointer("/faults/0/text").as_string()}, words);
    EXPECT_THAT(std::string{status.at_pointer("/stream/reason").as_string()}, words);
    // To who comes later, too.
    EXPECT_THAT(
        printed({"events", "--after", std::to_string(fault.seq - 1), "--topics", "fault", "--count", "1"}),
        words);
    std::printf("named after cycle %.0f\nstart:  %s%sevent:  %s\n%s%s", cycles_,
                started_.exit_code == 0 ? "good\n" : "", started_.err.c_str(),
                fault.data.at("text").as_string().c_str(), printed({"status"}).c_str(),
                printed({"stream", "status"}).c_str());
  }

  void expect_diagnosed(const std::string& finding) const {
    const Finished doctor = run_program("truepose", {"doctor", "--cell", cell_->cell_file(), "--json"});
    EXPECT_EQ(doctor.exit_code, 1) << doctor.out << doctor.err;
    const json::value findings = json::parse(doctor.out);
    const auto has = [](const json::value& one, const char* member, const std::string& text) {
      return std::string_view{one.at(member).as_string()}.contains(text);
    };
    EXPECT_TRUE(std::ranges::any_of(findings.as_array(), [&](const json::value& one) {
      return has(one, "level", "fault") && has(one, "area", "rsi") && has(one, "finding", finding) &&
             has(one, "next", "acknowledge");
    })) << doctor.out;
  }

  /// The log is written behind: looked into when the daemon has ended.
  void expect_logged(const std::string& level, const Words& words) { logged_.emplace_back(level, words); }
  std::string printed(const std::vector<std::string>& command) const {
    const Finished asked = cell_->truepose(command);
    EXPECT_EQ(asked.exit_code, 0) << asked.err;
    return asked.out;
  }

  TempFolder folder_;
  std::optional<LiveCell> cell_;

 private:
  std::chrono::microseconds end() {
    if (!cell_) return {};
    const auto stood_still = cell_->stood_still();
    cell_->daemon().terminate();
    EXPECT_EQ(cell_->daemon().wait(), 0);
    const std::string log = cell_->daemon().errors();
    for (const auto& [level, words] : std::exchange(logged_, {})) EXPECT_THAT(lines_of(log, level), words);
    return stood_still;
  }
  control::Event wait_for_fault(const std::string& code) {
    for (;;) {
      auto event = client_->next_event();
      if (!event) throw std::runtime_error{event.error().message};
      if (event->topic == "stream") cycles_ = number(event->data, "/cycles");
      if (cycles_ > kSoon_cycles) throw std::runtime_error{"no fault " + code};
      if (event->topic != "fault" || event->data.at("active") != true) continue;
      const std::string found{event->data.at("code").as_string()};
      if (found == code) return *std::move(event);
      if (found == "E_CELL") throw std::runtime_error{"the stream has ended without a fault " + code};
    }
  }
  static std::string lines_of(const std::string& log, const std::string& level) {
    std::string lines;
    for (std::size_t begin = 0, end; (end = log.find('\n', begin)) != std::string::npos; begin = end + 1) {
      const std::string line = log.substr(begin, end + 1 - begin);
      if (line.find(level) != std::string::npos) lines += line;
    }
    return lines;
  }

  std::optional<tools::RpcClient> client_;
  Finished started_;
  double cycles_ = 0;  // of the stream, as it was last heard of
  std::vector<std::pair<std::string, Words>> logged_;
};

TEST_F(ATroubledStream, SaysThatTheControllerTakesTheCorrectionUnderAnotherName) {
  experiment([&] {
    begin_with_ethernet("AK.A", "AKorr.A");
    EXPECT_EQ(start().exit_code, 0) << "every packet is answered";
    expect_named("E_STREAM_FROZEN",
                 AllOf(ContainsRegex("A[1-6] is sent -?[0-9.]+ deg and AIPos - ASPos shows"),
                       HasSubstr("another name for the correction"), HasSubstr("stream.ethernet_xml")));
    EXPECT_EQ(json::parse(printed({"stream", "status", "--json"})).at("state"), "holding");
    expect_diagnosed("the axes do not follow the correction");
  });
}

TEST_F(ATroubledStream, SaysThatTheControllerTakesAnotherSentype) {
  experiment([&] {
    begin_with_ethernet("<SENTYPE>TruePose", "<SENTYPE>ImFree");
    const Words words = AllOf(HasSubstr("does not take replies"), HasSubstr("another SENTYPE or other names"),
                              HasSubstr("stream.ethernet_xml"));
    start();  // refused where the fault comes before the answer
    expect_named("E_CELL", words);
    expect_diagnosed("another SENTYPE");
  });
}

TEST_F(ATroubledStream, ReportsThatItsControllerStoppedSendingAndRestartsAsItSays) {
  experiment([&] {
    begin({.faults = "[{kind: rsi-silence, at_cycle: 300, lasts_cycles: 100000}]"});
    EXPECT_EQ(start().exit_code, 0);
    expect_named("E_CELL", AllOf(ContainsRegex("no RSI packet for [0-4]\\.[0-9] s"), HasSubstr("the pendant"),
                                 HasSubstr("then acknowledge the fault, connect and start the stream")));
    EXPECT_EQ(json::parse(printed({"stream", "status", "--json"})).at("cycles"), 299);
    printed({"acknowledge"});
    printed({"connect"});
    EXPECT_EQ(start().exit_code, 0) << cell_->daemon().errors();
  });
}

TEST_F(ATroubledStream, SaysThatTheControllerHasAnotherArmOrAToolOrABase) {
  experiment([&] {
    const auto arm = folder_.write("arm.yaml", replaced(text_of(kRobotFile), "a: 1150", "a: 1050"));
    begin({.scenario = {{"  cycle_ms: 4", "  arm: " + arm.string() + "\n  cycle_ms: 4"}}});
    const Words words = AllOf(HasSubstr("RIst is 100.0 mm from"), HasSubstr("(allowed 1.0)"),
                              HasSubstr("correct robot.file"), HasSubstr("BAS(#TOOL,0) and BAS(#BASE,0)"));
    expect_no_start(words);
    expect_named("E_CELL", words);
  });
}

}  // namespace
}  // namespace truepose
