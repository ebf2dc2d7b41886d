#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/time.h>

#include <algorithm>
#include <array>
#include <boost/asio/buffer.hpp>
#include <boost/asio/connect.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/ip/udp.hpp>
#include <boost/asio/read_until.hpp>
#include <boost/asio/write.hpp>
#include <boost/json/parse.hpp>
#include <optional>
#include <string>
#include <variant>

#include "proto/eki/document_splitter.hpp"
#include "proto/eki/messages.hpp"
#include "tests/simulator_process.hpp"
#include "tests/tools/sim/eki_axes.hpp"
#include "tests/tools/sim/kr210.hpp"

namespace truepose::sim {
namespace {

namespace asio = boost::asio;
using asio::ip::tcp;
using asio::ip::udp;
using testing::HasSubstr;

const std::string kConfig = TRUEPOSE_SOURCE_DIR "/config";
const std::string kEthernetXml = kConfig + "/kuka/rsi/truepose_rsi_ethernet.xml";

/// Fails a receive that nothing comes for, instead of hanging the test.
template <typename Socket>
void give_up_after_a_minute(Socket& socket) {
  const timeval minute{.tv_sec = 60, .tv_usec = 0};
  setsockopt(socket.native_handle(), SOL_SOCKET, SO_RCVTIMEO, &minute, sizeof minute);
}

/// One EKI channel's client.
class EkiClient {
 public:
  explicit EkiClient(std::int64_t port) {
    socket_.connect({asio::ip::address_v4::loopback(), static_cast<std::uint16_t>(port)});
    give_up_after_a_minute(socket_);
  }

  void send(const eki::ToController& message) { asio::write(socket_, asio::buffer(eki::encode(message))); }

  /// The next document; nothing when the connection has ended.
  std::optional<eki::FromController> next() {
    for (;;) {
      if (const auto document = splitter_.next().value())
        return eki::decode_from_controller(*document).value().at(0);
      boost::system::error_code error;
      const std::size_t size = socket_.read_some(asio::buffer(buffer_), error);
      if (error) return std::nullopt;
      splitter_.feed({buffer_.data(), size});
    }
  }

  eki::Ack ack() { return std::get<eki::Ack>(next().value()); }

 private:
  asio::io_context context_;
  tcp::socket socket_{context_};
  eki::DocumentSplitter splitter_;
  std::array<char, 4096> buffer_{};
};

class SimulatorTest : public testing::Test {
 protected:
  SimulatorTest() { give_up_after_a_minute(pc_); }

  void scenario(const std::string& faults = "[]") {
    folder_.write("scenario.yaml", "robot: " + kConfig +
                                       "/robots/kr210_r2700_2.yaml\n"
                                       "robot_base: {x: 3400, y: 450, z: -1250, a: 165, b: 0, c: 0}\n"
                                       "reflector: {offset_mm: {x: 62, y: -48, z: 187}, "
                                       "facing: {x: 1, y: 0, z: 1}, acceptance_deg: 30}\n"
                                       "rsi: {ethernet_xml: " +
                                       kEthernetXml +
                                       "}\n"
                                       "stream_path: [[0, -90, 90, 0, 35, 0], [5, -90, 90, 0, 35, 0]]\n"
                                       "faults: " +
                                       faults + "\n");
  }

  std::vector<std::string> arguments(std::vector<std::string> more = {}) const {
    more.insert(more.begin(),
                {"--scenario", folder_.path() / "scenario.yaml", "--ready-file",
                 folder_.path() / "ready.json", "--rsi-target",
                 "127.0.0.1:" + std::to_string(pc_.local_endpoint().port()), "--speedup", "50", "--json"});
    return more;
  }

  boost::json::value ports(SimulatorProcess& simulator) const {
    const std::string text = simulator.ready(folder_.path() / "ready.json");
    EXPECT_NE(text, "") << simulator.errors();
    return boost::json::parse(text);
  }

  TempFolder folder_;
  asio::io_context context_;
  udp::socket pc_{context_, {asio::ip::address_v4::loopback(), 0}};
};

TEST_F(SimulatorTest, MovesTheArmAndEndsCleanlyOnSigterm) {
  scenario();
  SimulatorProcess simulator{folder_, arguments({"--truth-file", folder_.path() / "truth.json"})};
  const auto opened = ports(simulator);
  EkiClient motion{opened.at("eki_port").as_int64()}, state{opened.at("eki_state_port").as_int64()};
  EXPECT_EQ(std::get<eki::Hello>(motion.next().value()).serial, "210001");

  const JointVector target = deg(20, -80, 95, 0, 30, 0);
  motion.send(eki::Command{.id = 1, .type = eki::CommandType::Ptp, .axes_rad = axes_of(target)});
  EXPECT_EQ(motion.ack().state, eki::AckState::Accepted);
  EXPECT_EQ(motion.ack().state, eki::AckState::Moving);
  EXPECT_EQ(motion.ack().state, eki::AckState::InPosition);
  state.send(eki::Control{.id = 2});
  const auto there = std::get<eki::State>(state.next().value());
  EXPECT_TRUE(joints_of(there.axes_rad).isApprox(target, 1e-6));

  EkiClient second{opened.at("eki_port").as_int64()};
  EXPECT_FALSE(second.next()) << "a channel has one client";

  simulator.terminate();
  EXPECT_EQ(simulator.wait(), 0);
  const auto report = boost::json::parse(simulator.output());
  EXPECT_EQ(report.at("moves"), 1);
  EXPECT_EQ(report.at("truth"), boost::json::parse(text_of(folder_.path() / "truth.json")));
  EXPECT_EQ(report.at("truth").at("links").as_array().size(), 6u);
  EXPECT_FALSE(std::filesystem::exists(folder_.path() / "ready.json"));
}

TEST_F(SimulatorTest, CutsTheEkiLinkWhenTheScenarioSaysSoAndServesAgain) {
  scenario("[{at_ms: 10000, kind: eki-drop, lasts_ms: 5000}]");  // after 0.2 s, for 0.1 s
  SimulatorProcess simulator{folder_, arguments()};
  const std::int64_t port = ports(simulator).at("eki_port").as_int64();
  {
    EkiClient motion{port};
    while (motion.next()) {
    }
  }
  for (;;) {
    EkiClient again{port};
    if (again.next()) break;  // Hello
  }
  simulator.terminate();
  EXPECT_EQ(simulator.wait(), 0);
}

TEST_F(SimulatorTest, IsSteeredByLinesAndNamesWhatItDoesNotUnderstand) {
  scenario();
  SimulatorProcess simulator{folder_, arguments({"--admin-port", "0"})};
  tcp::socket admin{context_};
  admin.connect({asio::ip::address_v4::loopback(),
                 static_cast<std::uint16_t>(ports(simulator).at("admin_port").as_int64())});
  give_up_after_a_minute(admin);
  std::string received;
  const auto steer = [&](const std::string& line) {
    asio::write(admin, asio::buffer(line + "\n"));
    const std::size_t size = asio::read_until(admin, asio::dynamic_buffer(received), '\n');
    const std::string reply = received.substr(0, size - 1);
    received.erase(0, size);
    return reply;
  };
  EXPECT_EQ(steer(R"({"ask": "program"})").substr(0, 48),
            R"({"program":"TRUEPOSE_MOTION","state":"active","l)");
  EXPECT_EQ(steer(R"({"kind": "emergency-stop"})"), R"({"ok":true})");
  EXPECT_THAT(steer(R"({"ask": "program"})"), HasSubstr(R"("state":"stopped")"));
  EXPECT_THAT(steer(R"({"ask": "statistics"})"), HasSubstr(R"("measurements":0)"));
  EXPECT_THAT(steer("[]"), HasSubstr("expected an object, found []"));
  EXPECT_THAT(steer("stop it"), HasSubstr("byte 0: "));
  EXPECT_THAT(steer(R"({"ask": "program", "ask": "statistics"})"), HasSubstr("\\\"ask\\\" appears twice"));
  EXPECT_THAT(steer(R"({"kind": "fire"})"), HasSubstr("expected one of beam-break"));
  EXPECT_THAT(steer(R"({"kind": "beam-break", "at_ms": 5})"), HasSubstr("it begins now"));
  EXPECT_THAT(steer(R"({"ask": "weather"})"), HasSubstr("ask: expected one of program, statistics, found"));
}

TEST_F(SimulatorTest, NamesAPortThatIsInUseAndEndsWithThree) {
  scenario();
  tcp::acceptor holder{context_, {asio::ip::address_v4::loopback(), 0}};
  const std::string port = std::to_string(holder.local_endpoint().port());
  for (const std::string option : {"--eki-port", "--tracker-port"}) {
    SimulatorProcess simulator{folder_, arguments({option, port})};
    EXPECT_EQ(simulator.wait(), 3);
    EXPECT_THAT(simulator.errors(), HasSubstr("port " + port)) << option;
    EXPECT_EQ(simulator.output(), "");
  }
}

TEST_F(SimulatorTest, RefusesBadUsageWithOneLine) {
  scenario();
  const std::vector<std::vector<std::string>> bad{{},
                                                  {"--scenario"},
                                                  {"--scenario", "/does/not/exist.yaml"},
                                                  arguments({"--speedup", "0"}),
                                                  arguments({"--nonsense"})};
  for (const auto& options : bad) {
    SimulatorProcess simulator{folder_, options};
    EXPECT_EQ(simulator.wait(), 2);
    EXPECT_EQ(std::ranges::count(simulator.errors(), '\n'), 1) << simulator.errors();
  }
  SimulatorProcess simulator{folder_,
                             {"--scenario", folder_.path() / "scenario.yaml", "--rsi-target", "127.0.0.1"}};
  EXPECT_EQ(simulator.wait(), 2);
  EXPECT_THAT(simulator.errors(), HasSubstr("--rsi-target: expected host:port"));
}

}  // namespace
}  // namespace truepose::sim
