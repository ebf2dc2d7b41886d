#include "tools/sim/controller/rsi_client.hpp"

#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/arm/forward.hpp"
#include "core/math/angles.hpp"
#include "tests/tools/sim/kr210.hpp"

namespace truepose::sim {
namespace {

using Reply = RsiClient::Reply;
using namespace std::chrono_literals;

constexpr std::uint64_t kFirstIpoc = 4'208'163;
const JointVector kStart = deg(0, -90, 90, 0, 35, 0);

rsi::EthernetConfig ethernet(bool hold_on = true) {
  std::string receive;
  for (int i = 1; i <= 6; ++i) {
    receive += "<ELEMENT TAG=\"AK.A" + std::to_string(i) + "\" TYPE=\"DOUBLE\" INDX=\"" + std::to_string(i) +
               "\" HOLDON=\"" + (hold_on ? "1" : "0") + "\"/>";
  }
  const std::string xml =
      "<ROOT><CONFIG><IP_NUMBER>127.0.0.1</IP_NUMBER><PORT>49152</PORT><SENTYPE>TruePose</SENTYPE>"
      "<ONLYSEND>FALSE</ONLYSEND></CONFIG><SEND><ELEMENTS>"
      "<ELEMENT TAG=\"DEF_RIst\" TYPE=\"DOUBLE\" INDX=\"INTERNAL\"/>"
      "<ELEMENT TAG=\"DEF_AIPos\" TYPE=\"DOUBLE\" INDX=\"INTERNAL\"/>"
      "<ELEMENT TAG=\"DEF_ASPos\" TYPE=\"DOUBLE\" INDX=\"INTERNAL\"/>"
      "<ELEMENT TAG=\"DEF_Delay\" TYPE=\"LONG\" INDX=\"INTERNAL\"/>"
      "</ELEMENTS></SEND><RECEIVE><ELEMENTS>" +
      receive + "<ELEMENT TAG=\"Stop\" TYPE=\"BOOL\" INDX=\"7\" HOLDON=\"1\"/></ELEMENTS></RECEIVE></ROOT>";
  return rsi::parse_ethernet_config(xml).value();
}

std::shared_ptr<RsiProgram> program_along(std::vector<JointVector> points) {
  return std::make_shared<StreamPath>(kr210(), std::move(points), 1.0);
}

RsiSetup rsi_setup(bool hold_on = true) {
  return {.nominal = kr210(),
          .ethernet = ethernet(hold_on),
          .context = rsi::truepose_context({.timeout_cycles = 5, .max_total_deg = 5}),
          .cycle = 4ms};
}

class RsiClientTest : public testing::Test {
 protected:
  explicit RsiClientTest(bool hold_on = true) : RsiClientTest{rsi_setup(hold_on)} {}
  explicit RsiClientTest(const RsiSetup& what, std::vector<JointVector> points = {kStart})
      : codec{what.ethernet}, client{what, program_along(std::move(points)), kFirstIpoc} {}

  rsi::RobotFrame begin() { return rsi::decode_robot_frame(client.begin_cycle()).value(); }

  std::string reply(std::uint64_t ipoc, double a1_deg, bool stop = false) {
    rsi::SensorFrame frame;
    frame.ipoc = ipoc;
    frame.axis_correction_rad = rsi::Axes{a1_deg * kRadPerDeg};
    frame.stop = stop;
    std::array<char, rsi::kMaxFrameBytes> buffer;
    return std::string{codec.encode(frame, buffer).value()};
  }

  /// A whole cycle with an answer in time.
  std::optional<RsiEnd> answered(double a1_deg, bool stop = false) {
    const std::uint64_t ipoc = begin().ipoc;
    EXPECT_EQ(client.receive(reply(ipoc, a1_deg, stop)).reply, Reply::Valid);
    return client.end_cycle();
  }

  std::optional<RsiEnd> unanswered() {
    begin();
    return client.end_cycle();
  }

  /// In force.
  double a1_deg() const { return client.correction_rad()[0] * kDegPerRad; }

  rsi::SensorFrameCodec codec;
  RsiClient client;
};

class RsiClientWithoutHold : public RsiClientTest {
 protected:
  RsiClientWithoutHold() : RsiClientTest{false} {}
};

/// RKorr instead of AK, in the system of a number; the TCP stands at kStart.
class RsiClientWithPoseCorrection : public testing::Test {
 protected:
  static RsiSetup in_system(int system) {
    RsiSetup setup{
        .nominal = kr210(), .ethernet = ethernet(), .context = rsi::truepose_context({.timeout_cycles = 5})};
    const std::array names{"X", "Y", "Z", "A", "B", "C"};
    for (std::size_t i = 0; i < names.size(); ++i)
      setup.ethernet.receive[i].tag = std::string{"RKorr."} + names[i];
    for (rsi::ContextObject& object : setup.context.objects) {
      if (object.type == "AXISCORR") object = {.type = "POSCORR", .id = "POSCORR1", .inputs = object.inputs};
    }
    const_cast<rsi::ContextObject*>(setup.context.of_type("POSCORR"))->values = {
        {"RefCorrSys", std::to_string(system)}, {"UpperLimZ", "30"}};
    return setup;
  }
  /// Where the TCP is when the correction has come in effect.
  Eigen::Isometry3d corrected(int system, const std::string& attributes) {
    client.emplace(in_system(system), program, kFirstIpoc);
    for (int cycle = 0; cycle < 2; ++cycle) {
      const std::uint64_t ipoc = rsi::decode_robot_frame(client->begin_cycle()).value().ipoc;
      client->receive("<Sen Type=\"TruePose\"><RKorr " + attributes + "/><IPOC>" + std::to_string(ipoc) +
                      "</IPOC></Sen>");
      if (!end) end = client->end_cycle();
    }
    client->begin_cycle();
    return forward_kinematics(kr210(), client->axes()) * program->tool;
  }

  /// Stands, with a tool and a base that is turned.
  struct Standing : StreamPath {
    Standing() : StreamPath{kr210(), {kStart}, 1} {}
    FlowSources sources() const override {
      FlowSources sources = StreamPath::sources();
      sources.tool = tool;
      sources.base = base;
      return sources;
    }
    Eigen::Isometry3d tool = pose_from_kuka({10, 20, 300}, {30, 0, 0}),
                      base = pose_from_kuka({500, 0, 0}, {90, 0, 0});
  };
  const std::shared_ptr<Standing> program = std::make_shared<Standing>();
  const Eigen::Isometry3d X = forward_kinematics(kr210(), kStart) * program->tool;
  std::optional<RsiClient> client;
  std::optional<RsiEnd> end;
};

TEST_F(RsiClientWithPoseCorrection, MovesTheTcpAlongItsSystem) {
  const Eigen::Vector3d along{1, 2, 3};
  const std::string attributes = "X=\"1\" Y=\"2\" Z=\"3\"";
  for (const auto& [system, turned] : {std::pair{0, Eigen::Matrix3d::Identity().eval()},
                                       {1, program->base.linear().eval()},
                                       {2, Eigen::Matrix3d::Identity().eval()},
                                       {3, X.linear().eval()}}) {
    const Eigen::Isometry3d now = corrected(system, attributes);
    EXPECT_LT((now.translation() - X.translation() - turned * along).norm(), 1e-6) << "system " << system;
    EXPECT_LT(angle_between(now.linear(), X.linear()), 1e-9);
  }
}

TEST_F(RsiClientWithPoseCorrection, TurnsAboutTheTcp) {
  const Eigen::Isometry3d now = corrected(1, "A=\"2\"");
  EXPECT_LT((now.translation() - X.translation()).norm(), 1e-6);
  const Eigen::Vector3d turn = turn_between(X.linear(), now.linear());
  EXPECT_LT((turn - 2 * kRadPerDeg * Eigen::Vector3d::UnitZ()).norm(), 1e-9);
  EXPECT_FALSE(end);
}

TEST_F(RsiClientWithPoseCorrection, ClampsAndStopsAtItsLimits) {
  const Eigen::Isometry3d now = corrected(2, "X=\"-8\" B=\"9\"");
  EXPECT_NEAR((now.translation() - X.translation()).x(), -5, 1e-6);
  EXPECT_NEAR(angle_between(now.linear(), X.linear()) * kDegPerRad, 5, 1e-6);
  EXPECT_EQ(client->counters().clamped, 2U);
  EXPECT_FALSE(end);
  corrected(2, "Z=\"7\"");
  EXPECT_EQ(end, RsiEnd::PoseMonitor) << "6 mm, where no POSCORRMON says otherwise";
}

TEST_F(RsiClientWithPoseCorrection, AlongThePathIsRefused) {
  EXPECT_THROW((RsiClient{in_system(4), program, kFirstIpoc}), std::invalid_argument);
}

class RsiClientWithDrives : public RsiClientTest {
 protected:
  explicit RsiClientWithDrives(std::vector<JointVector> points = {kStart})
      : RsiClientTest{lagging(), points} {}

  static RsiSetup lagging() {
    RsiSetup with_drives = rsi_setup();
    with_drives.servo = {.dead_time = 12ms, .lag = {40ms, 40ms, 40ms, 40ms, 40ms, 80ms}};
    for (rsi::ContextObject& object : with_drives.context.objects) {
      if (object.type == "ETHERNET") object.values["Precision"] = "9";
    }
    return with_drives;
  }
};

class RsiClientInMotion : public RsiClientWithDrives {
 protected:
  RsiClientInMotion() : RsiClientWithDrives{{kStart, deg(100, -90, 90, 0, 35, 0)}} {}
};

class RsiClientThatIgnores : public RsiClientTest {
 protected:
  RsiClientThatIgnores() : RsiClientTest{ignoring()} {}
  static RsiSetup ignoring() {
    RsiSetup deaf = rsi_setup();
    deaf.ignores_correction = true;
    return deaf;
  }
};

TEST_F(RsiClientTest, CountsIpocUpByTheCycleAndMovesTheActualAxesOnly) {
  EXPECT_EQ(begin().ipoc, kFirstIpoc);
  client.end_cycle();
  EXPECT_EQ(begin().ipoc, kFirstIpoc + 4);
  client.receive(reply(kFirstIpoc + 4, 0.5));
  client.end_cycle();
  const rsi::RobotFrame frame = begin();
  EXPECT_NEAR((*frame.aipos_rad)[0] * kDegPerRad, 0.5, 1e-4);
  EXPECT_NEAR((*frame.aspos_rad)[0], 0, 1e-12);
  EXPECT_FALSE(frame.rsol) << "not in the SEND list";
  const Eigen::Vector3d p = forward_kinematics(kr210(), client.axes()).translation();
  EXPECT_NEAR(frame.rist->x_mm, p.x(), 1e-4);
  EXPECT_NEAR(frame.rist->y_mm, p.y(), 1e-4);
}

TEST_F(RsiClientTest, CountsALateReplyIgnoresItAndHolds) {
  answered(0.25);
  const std::uint64_t late = begin().ipoc;
  client.end_cycle();
  EXPECT_EQ(client.counters().lost, 1u);
  const rsi::RobotFrame next = begin();
  EXPECT_EQ(next.delay, 1);
  const RsiClient::Verdict verdict = client.receive(reply(late, 0.5));
  EXPECT_EQ(verdict.reply, Reply::Late);
  EXPECT_EQ(verdict.cycles_ago, 1u);
  EXPECT_EQ(client.receive(reply(next.ipoc, 0.75)).reply, Reply::Valid);
  EXPECT_NEAR(a1_deg(), 0.25, 1e-9);
  client.end_cycle();
  EXPECT_NEAR(a1_deg(), 0.75, 1e-9);

  const RsiCounters& counters = client.counters();
  EXPECT_EQ(counters.cycles, 3u);
  EXPECT_EQ(counters.answered, 2u);
  EXPECT_EQ(counters.late, 1u);
  EXPECT_EQ(counters.lost, 0u);
}

TEST_F(RsiClientTest, RefusesAWrongIpocAndOneThatWasAnsweredBefore) {
  answered(0.25);
  const std::uint64_t ipoc = begin().ipoc;
  for (const std::uint64_t wrong : {ipoc + 4, ipoc + 1, ipoc - 4, kFirstIpoc - 4, std::uint64_t{0}}) {
    EXPECT_EQ(client.receive(reply(wrong, 1)).reply, Reply::WrongIpoc) << wrong;
  }
  client.end_cycle();
  EXPECT_NEAR(a1_deg(), 0.25, 1e-9);
  EXPECT_EQ(client.counters().wrong_ipoc, 5u);
  EXPECT_EQ(client.counters().lost, 1u);
}

TEST_F(RsiClientTest, DiscardsAnotherSentypeAndGarbage) {
  const std::uint64_t ipoc = begin().ipoc;
  std::string other = reply(ipoc, 1);
  other.replace(other.find("TruePose"), 8, "ImFree!!");
  EXPECT_EQ(client.receive(other).reply, Reply::Rejected);
  EXPECT_EQ(client.receive("<Sen").reply, Reply::Rejected);
  EXPECT_EQ(client.receive("").reply, Reply::Rejected);
  client.end_cycle();
  EXPECT_EQ(client.counters().rejected, 3u);
  EXPECT_EQ(client.counters().lost, 1u);
  EXPECT_EQ(begin().delay, 1);
}

TEST_F(RsiClientTest, SaysOnceForEachCauseWhyAReplyIsRejected) {
  const std::uint64_t ipoc = begin().ipoc;
  const auto with_changed = [&](const std::string& what, const std::string& to) {
    std::string changed = reply(ipoc, 1);
    changed.replace(changed.find(what), what.size(), to);
    return changed;
  };
  const std::string number = std::to_string(ipoc);
  const std::vector<std::pair<std::string, std::string>> cases{
      {"hello\n", "is no XML document Sen (it begins \"hello.\"). Send <Sen Type=\"TruePose\">."},
      {with_changed("TruePose", "ImFree"),
       "SENTYPE is \"ImFree\", the configuration says \"TruePose\". Send that as Type of Sen."},
      {with_changed(number, "x"), "IPOC is \"x\", no whole number. Copy the IPOC of the packet."},
      {with_changed("A1=\"", "A1=\"x"),
       "AK.A1 is \"x1.000000\", no number. Send digits with a decimal point."},
      {reply(5, 1), "IPOC is 5, the packet has " + number + ". Copy it unchanged."}};
  for (const auto& [datagram, line] : cases) {
    client.receive(datagram);
    EXPECT_EQ(client.take_rejections(), std::vector{line});
    client.receive(datagram);
    EXPECT_EQ(client.take_rejections(), std::vector<std::string>{}) << "said before";
  }
  client.receive(reply(ipoc, 1));
  EXPECT_EQ(client.take_rejections(), std::vector<std::string>{}) << "not rejected";
  client.receive(reply(ipoc, 1));
  EXPECT_EQ(
      client.take_rejections(),
      std::vector{"IPOC is " + number + ", which was answered before. Send one reply for each packet."});
  client.end_cycle();
  client.restart(0, std::nullopt);
  begin();
  client.receive("hello\n");
  EXPECT_EQ(client.take_rejections(), std::vector{cases[0].second}) << "another session";
}

TEST_F(RsiClientTest, HoldsTheCorrectionWithHoldon) {
  answered(0.5);
  unanswered();
  EXPECT_NEAR(a1_deg(), 0.5, 1e-9);
  EXPECT_NEAR(client.counters().max_step_rad, 0.5 * kRadPerDeg, 1e-9);
}

TEST_F(RsiClientWithoutHold, JumpsBackToZeroInOneCycle) {
  answered(0.5);
  answered(1.0);
  unanswered();
  EXPECT_EQ(a1_deg(), 0);
  EXPECT_NEAR(client.counters().max_step_rad, 1.0 * kRadPerDeg, 1e-9);
}

TEST_F(RsiClientTest, StopsWithKss29002AfterTooManyCyclesInARowWithoutAReply) {
  for (int i = 0; i < 4; ++i) EXPECT_EQ(unanswered(), std::nullopt);
  EXPECT_EQ(answered(0), std::nullopt) << "a reply restarts the count";
  for (int i = 0; i < 4; ++i) EXPECT_EQ(unanswered(), std::nullopt);
  EXPECT_EQ(unanswered(), RsiEnd::Timeout);
}

TEST_F(RsiClientTest, ClampsSilentlyAtTheLimitOfAxiscorr) {
  answered(5.1);
  EXPECT_NEAR(a1_deg(), 5, 1e-9);
  answered(-7);
  EXPECT_NEAR(a1_deg(), -5, 1e-9);
  EXPECT_EQ(client.counters().clamped, 2u);
  EXPECT_EQ(client.counters().answered, 2u);
}

TEST_F(RsiClientTest, LeavesMovecorrOnTheStopBit) {
  EXPECT_EQ(answered(0.5), std::nullopt);
  EXPECT_EQ(answered(0.5, true), RsiEnd::Off);
}

TEST_F(RsiClientWithDrives, MovesTheAxesByACorrectionAfterDeadTimeAndLag) {
  answered(1);
  for (int cycle = 0; cycle < 3; ++cycle) {
    EXPECT_EQ((*begin().aipos_rad)[0], 0) << "in dead time";
    client.end_cycle();
  }
  EXPECT_NEAR((*begin().aipos_rad)[0] * kDegPerRad, 1 - std::exp(-0.1), 1e-9);
  EXPECT_NEAR(a1_deg(), 1, 1e-9) << "in force since it was taken";
  EXPECT_NEAR(client.counters().max_step_rad, 1 * kRadPerDeg, 1e-12);
}

TEST_F(RsiClientInMotion, LagsBehindTheProgramWithWhateverIsActual) {
  rsi::RobotFrame frame;
  for (int cycle = 0; cycle < 200; ++cycle) {
    frame = begin();
    client.receive(reply(frame.ipoc, 0));
    client.end_cycle();
  }
  // 117 deg/s for 52 ms, and half a cycle for that the drives are given steps.
  const double behind_deg = ((*frame.aspos_rad)[0] - (*frame.aipos_rad)[0]) * kDegPerRad;
  EXPECT_NEAR(behind_deg, 117 * 0.052, 117 * 0.0021);
  const Eigen::Vector3d p = forward_kinematics(kr210(), client.axes()).translation();
  EXPECT_NEAR(frame.rist->y_mm, p.y(), 1e-6);
}

TEST_F(RsiClientThatIgnores, TakesRepliesAndMovesNothing) {
  answered(1);
  answered(1);
  EXPECT_EQ(a1_deg(), 0);
  EXPECT_NEAR((*begin().aipos_rad)[0], 0, 1e-12);
  EXPECT_EQ(client.counters().answered, 2u);
  EXPECT_EQ(client.counters().max_step_rad, 0);
}

class RsiClientThatOnlySends : public RsiClientTest {
 protected:
  RsiClientThatOnlySends() : RsiClientTest{only_sending()} {}
  static RsiSetup only_sending() {
    RsiSetup setup = rsi_setup();
    setup.ethernet.only_send = true;
    return setup;
  }
};

TEST_F(RsiClientThatOnlySends, ReadsNoReplyAndWaitsForNone) {
  for (int cycle = 0; cycle < 50; ++cycle) {
    const std::uint64_t ipoc = begin().ipoc;
    EXPECT_EQ(client.receive(reply(ipoc, 1)).reply, Reply::Unread);
    EXPECT_FALSE(client.end_cycle());
  }
  EXPECT_EQ(a1_deg(), 0);
  EXPECT_EQ(client.counters().answered, 0u);
  EXPECT_EQ(begin().delay, 0);
}

/// A program that is where RSI applies nothing new, as in PTP under #IPO.
struct Uncorrected : StreamPath {
  using StreamPath::StreamPath;
  bool corrects() const override { return corrected; }
  bool corrected = true;
};

TEST(RsiClient, KeepsTheCorrectionThatItHasWhereItsProgramTakesNoNewOne) {
  const RsiSetup what = rsi_setup();
  const auto program = std::make_shared<Uncorrected>(kr210(), std::vector<JointVector>{kStart}, 1.0);
  RsiClient client{what, program, kFirstIpoc};
  const rsi::SensorFrameCodec codec{what.ethernet};
  std::array<char, rsi::kMaxFrameBytes> buffer;
  for (const double a1_deg : {1.0, 2.0, 3.0}) {
    program->corrected = a1_deg != 2.0;
    const std::uint64_t ipoc = rsi::decode_robot_frame(client.begin_cycle()).value().ipoc;
    client.receive(
        codec.encode({.ipoc = ipoc, .axis_correction_rad = rsi::Axes{a1_deg * kRadPerDeg}}, buffer).value());
    client.end_cycle();
    EXPECT_NEAR(client.correction_rad()[0] * kDegPerRad, a1_deg == 2.0 ? 1 : a1_deg, 1e-9);
  }
}

TEST_F(RsiClientTest, RestartsWithNoCorrectionWhenRsiIsSwitchedOffAndOn) {
  answered(0.5);
  unanswered();
  client.restart(10, std::nullopt);
  EXPECT_EQ(a1_deg(), 0);
  const rsi::RobotFrame first = begin();
  EXPECT_EQ(first.ipoc, kFirstIpoc + 4 + 11 * 4);
  EXPECT_EQ(first.delay, 0);
  EXPECT_NEAR((*first.aipos_rad)[0], 0, 1e-12);
  EXPECT_EQ(client.receive(reply(kFirstIpoc + 4, 1)).reply, Reply::WrongIpoc) << "of the session before";
  EXPECT_EQ(client.receive(reply(first.ipoc, 0.25)).reply, Reply::Valid);
  client.end_cycle();
  EXPECT_NEAR(client.counters().max_step_rad, 0.5 * kRadPerDeg, 1e-9) << "to nothing in force is no step";
  client.restart(0, 1000);
  EXPECT_EQ(begin().ipoc, 1000u);
}

TEST_F(RsiClientTest, KeepsWhatIsInForceInASilenceThatItsClockGoesThrough) {
  answered(0.5);
  for (int cycle = 0; cycle < 250; ++cycle) client.pass();
  const rsi::RobotFrame frame = begin();
  EXPECT_EQ(frame.ipoc, kFirstIpoc + 251 * 4);
  EXPECT_EQ(frame.delay, 0);
  EXPECT_NEAR((*frame.aipos_rad)[0] * kDegPerRad, 0.5, 1e-4);
  EXPECT_EQ(client.receive(reply(frame.ipoc, 0.5)).reply, Reply::Valid);
}

TEST_F(RsiClientTest, AnswersToTheTimeStampThatItJumpedTo) {
  answered(0.5);
  client.jump_ipoc(-1'000'000);
  const rsi::RobotFrame frame = begin();
  EXPECT_EQ(frame.ipoc, kFirstIpoc - 1'000'000 + 4);
  EXPECT_EQ(client.receive(reply(frame.ipoc, 0.5)).reply, Reply::Valid);
  EXPECT_NEAR(a1_deg(), 0.5, 1e-9);
}

TEST(RsiClient, DropsWhatTheConfigurationHoldsOnRequest) {
  RsiSetup dropping = rsi_setup();
  dropping.hold_on = false;
  RsiClient client{dropping, program_along({kStart}), kFirstIpoc};
  client.begin_cycle();
  client.receive(
      "<Sen Type=\"TruePose\"><AK A1=\"1\" A2=\"0\" A3=\"0\" A4=\"0\" A5=\"0\" "
      "A6=\"0\"/><IPOC>4208163</IPOC></Sen>");
  client.end_cycle();
  EXPECT_NEAR(client.correction_rad()[0], 1 * kRadPerDeg, 1e-12);
  client.begin_cycle();
  client.end_cycle();
  EXPECT_EQ(client.correction_rad()[0], 0);
}

TEST(RsiClient, CanCountItsDelayInARow) {
  RsiSetup in_a_row = rsi_setup();
  in_a_row.consecutive_delay = true;
  RsiClient client{in_a_row, program_along({kStart}), kFirstIpoc};
  const auto delay = [&client] { return rsi::decode_robot_frame(client.begin_cycle()).value().delay; };
  delay();
  client.end_cycle();
  EXPECT_EQ(delay(), 1);
  client.receive("<Sen Type=\"TruePose\"><IPOC>4208167</IPOC></Sen>");
  client.end_cycle();
  EXPECT_EQ(delay(), 0);
}

TEST_F(RsiClientTest, NamesWhatARealControllerIgnoresWithoutAWordOnce) {
  for (int cycle = 0; cycle < 2; ++cycle) {
    const std::string ipoc = std::to_string(begin().ipoc);
    client.receive(
        "<Sen Type=\"TruePose\"><RKorr X=\"1\" Y=\"0\"/><AK A1=\"1\" A2=\"0\" A3=\"0\" A4=\"0\" A5=\"0\" "
        "A6=\"0\" A7=\"0\"/><Stop>0</Stop><IPOC>" +
        ipoc + "</IPOC></Sen>");
    client.end_cycle();
    EXPECT_EQ(client.take_unknown_names(),
              cycle == 0 ? (std::vector<std::string>{"RKorr", "AK.A7"}) : std::vector<std::string>{});
  }
}

}  // namespace
}  // namespace truepose::sim
