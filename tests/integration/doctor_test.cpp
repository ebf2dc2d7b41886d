// What truepose doctor says of a cell in which something is wrong, over the real protocols on loopback. Every
// single finding is in tests/tools/doctor/diagnose_test.cpp.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/udp.hpp>
#include <boost/json/parse.hpp>

#include "config/cell_config.hpp"
#include "tests/await.hpp"
#include "tests/integration/asked_doctor.hpp"
#include "tests/integration/healthy_frame.hpp"
#include "tests/integration/live_cell.hpp"
#include "tests/tools/doctor/scripted_controller.hpp"

namespace truepose {
namespace {

namespace json = boost::json;
using testing::AllOf;
using testing::Contains;
using testing::HasSubstr;
using testing::ResultOf;

std::string with(std::string text, const std::string& from, const std::string& to) {
  const std::size_t at = text.find(from);
  if (at == std::string::npos) throw std::runtime_error{"there is no " + from};
  return text.replace(at, from.size(), to);
}

// ---- A faulty network ----

/// truepose-proxy in front of one port of this machine.
class FaultyNetwork {
 public:
  FaultyNetwork(std::uint16_t target, const std::string& faults)
      : process_{folder_.path(),
                 "truepose-proxy",
                 {"--tcp", "127.0.0.1:0=127.0.0.1:" + std::to_string(target), "--set", faults, "--seed", "1",
                  "--ready-file", folder_.path() / "ready"}} {}

  std::uint16_t port() {
    const std::string text = process_.ready(folder_.path() / "ready");
    if (text.empty()) throw std::runtime_error{process_.errors()};
    const json::value ready = json::parse(text);
    const std::string listens{ready.at_pointer("/listen/0").as_string()};
    return static_cast<std::uint16_t>(std::stoi(listens.substr(listens.find(':') + 1)));
  }

 private:
  TempFolder folder_;
  Process process_;
};

// ---- The doctor ----

auto says(const std::string& level, const std::string& area, const std::string& finding,
          const std::string& next) {
  return Contains(AllOf(ResultOf([](const Said& s) { return s.level; }, level),
                        ResultOf([](const Said& s) { return s.area; }, area),
                        ResultOf([](const Said& s) { return s.finding; }, HasSubstr(finding)),
                        ResultOf([](const Said& s) { return s.next; }, HasSubstr(next))));
}

class TheDoctor : public testing::Test {
 protected:
  /// Changes the cell file, in which addresses of this run stand.
  void edit(const std::string& from, const std::string& to) {
    cell.write("cell.yaml", with(text_of(cell.cell_file()), from, to));
  }
  /// Puts a faulty network before what stands behind a key of the cell file.
  void disturb(const std::string& key, const std::string& faults) {
    const std::string text = text_of(cell.cell_file()), before = key + ": 127.0.0.1:";
    const auto port = static_cast<std::uint16_t>(std::stoi(text.substr(text.find(before) + before.size())));
    network.emplace_back(std::make_unique<FaultyNetwork>(port, faults));
    edit(before + std::to_string(port), before + std::to_string(network.back()->port()));
  }
  ScriptedController::Frame healthy() const {
    return [config = config::load_cell(cell.cell_file())](std::uint64_t cycle) {
      return wire(healthy_frame(config, cycle));
    };
  }
  void send(ScriptedController::Frame frame, const std::string& from = "127.0.0.1") {
    controller = std::make_unique<ScriptedController>(cell.rsi_port(), std::move(frame), from);
  }

  std::vector<Said> asked(std::optional<int> exit_code) const { return doctor_of(cell, exit_code); }

  LiveCell cell;
  std::vector<std::unique_ptr<FaultyNetwork>> network;
  std::unique_ptr<ScriptedController> controller;
};

/// Root sees packets of tests that run at the same time, whose controllers have this one's address too.
const auto of_others = says("fault", "rsi", "sends RSI packets to 127.0.0.1:", "IP_NUMBER");

TEST_F(TheDoctor, FindsNoFaultInAHealthyCellButThatItsDaemonDoesNotRun) {
  send(healthy());
  const auto said = asked(1);
  EXPECT_THAT(said, says("ok", "rsi", "sends good frames", ""));
  EXPECT_THAT(said, says("ok", "robot", "#KR210R2700_2 C4 FLR, serial 210001", ""));
  EXPECT_THAT(said, says("ok", "tracker", "can measure", ""));
  EXPECT_THAT(said, says("fault", "daemon", "cannot be reached", "trueposed --config"));
}

TEST_F(TheDoctor, NamesElementsThatDifferASilentTrackerAndAnotherReflector) {
  send([frame = healthy()](std::uint64_t cycle) { return with(frame(cycle), "<Tp ", "<Tq "); });
  edit("reflector: CCR-1.5in", "reflector: TBR-0.5in");
  const auto said = asked(1);
  EXPECT_THAT(said, says("fault", "rsi", "not in it: Tq; not sent: Tp.Ask, Tp.Pro, Tp.Mode, Tp.Ov, Tp.Cell",
                         "truepose_rsi_ethernet.xml"));
  EXPECT_THAT(said, says("fault", "tracker", "TBR-0.5in", "tracker.reflector"));
}

TEST_F(TheDoctor, NamesAnotherCycleAndASilentTracker) {
  send([config = config::load_cell(cell.cell_file())](std::uint64_t cycle) {
    rsi::RobotFrame frame = healthy_frame(config, cycle);
    frame.ipoc *= 3;
    return wire(frame);
  });
  disturb("address", R"({"half_open": true})");
  const auto said = asked(1);
  EXPECT_THAT(said, says("fault", "rsi", "rises by 12", "stream.cycle_ms"));
  EXPECT_THAT(said, says("fault", "tracker", "did not answer", "tracker.address"));
}

TEST_F(TheDoctor, NamesAnotherArmAndItsFewDecimals) {
  send([config = config::load_cell(cell.cell_file())](std::uint64_t cycle) {
    rsi::RobotFrame frame = healthy_frame(config, cycle);
    frame.rist->z_mm += 300;
    return wire(frame, 1);
  });
  edit("expect_model: KR210R2700_2", "expect_model: KR16");
  const auto said = asked(1);
  EXPECT_THAT(said, says("fault", "rsi", "RIst is 300.0 mm", "robot.file"));
  EXPECT_THAT(said, says("warning", "rsi", "Precision 1 rounds the axes", "Precision"));
  EXPECT_THAT(said, says("fault", "robot", "the cell expects KR16", "robot.file"));
}

TEST_F(TheDoctor, NamesAControllerThatSendsToAnotherPort) {
  const std::uint16_t other = free_udp_port();
  controller = std::make_unique<ScriptedController>(other, healthy());
  const auto said = asked(1);
  EXPECT_THAT(said, testing::Not(says("warning", "rsi", "no RSI packet comes to 127.0.0.1:", "RSI_ON")));
  EXPECT_THAT(said,
              says("fault", "rsi", "sends RSI packets to 127.0.0.1:" + std::to_string(other), "IP_NUMBER"));
}

TEST_F(TheDoctor, NamesWhoHoldsThePort) {
  boost::asio::io_context io;
  using boost::asio::ip::udp;
  const udp::socket holder{io, {boost::asio::ip::address_v4::loopback(), cell.rsi_port()}};
  EXPECT_THAT(asked(1),
              says("fault", "rsi", "(process " + std::to_string(getpid()) + ")", "end that process"));
}

TEST_F(TheDoctor, NamesAnAddressThatThisPcDoesNotHave) {
  const std::string listen = "listen: 127.0.0.1:" + std::to_string(cell.rsi_port());
  edit(listen, "listen: 192.0.2.77:" + std::to_string(cell.rsi_port()));
  EXPECT_THAT(asked(1), says("fault", "rsi", "192.0.2.77", "an address of this PC (lo 127.0.0.1"));
}

TEST_F(TheDoctor, NamesACellThatIsSwitchedOff) {
  cell.end_simulator();
  const auto said = asked(1);
  EXPECT_THAT(said,
              testing::AnyOf(says("fault", "rsi", "no RSI packet comes to 127.0.0.1:", "RSI_ON"), of_others));
  EXPECT_THAT(said, says("fault", "robot", "refused", "start truepose_motion"));
  EXPECT_THAT(said, says("fault", "tracker", "no tracker answers", "switch the tracker on"));
}

TEST_F(TheDoctor, AsksTheDaemonThatRuns) {
  cell.start_daemon();
  const auto said = asked(std::nullopt);
  EXPECT_THAT(said, says("ok", "daemon", "runs, state disconnected", ""));
  EXPECT_THAT(said, testing::AnyOf(says("warning", "rsi", "no RSI packet comes to", "RSI_ON"), of_others));
  EXPECT_THAT(said, says("ok", "robot", "serial 210001", ""));
}

TEST_F(TheDoctor, TellsTheDaemonOfAnotherCellFromItsOwn) {
  cell.start_daemon();
  edit("name: demo", "name: press_shop");
  const auto said = asked(1);
  EXPECT_THAT(said, says("fault", "daemon", "is that of cell demo, not of press_shop", "start it"));
  EXPECT_THAT(said, says("fault", "rsi", "in use by trueposed", "end that process"));
}

TEST_F(TheDoctor, TellsWhatTheDaemonDrops) {
  cell.start_daemon();
  send(healthy(), "127.0.0.2");
  auto client = cell.client();
  const auto refused = [&] { return client.call("stream.status", {})->at("refused").is_string(); };
  await("the daemon has refused a datagram", refused);
  EXPECT_THAT(asked(1), says("fault", "rsi", "127.0.0.2", "robot.rsi_peer"));
}

}  // namespace
}  // namespace truepose
