#include "tools/sim/rsi_client.hpp"

#include <gtest/gtest.h>

#include <chrono>
#include <string>
#include <vector>

#include "core/kinematics/angles.hpp"
#include "core/kinematics/forward.hpp"
#include "tests/tools/sim/kr210.hpp"
#include "tools/sim/rsi_statistics.hpp"

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

class RsiClientTest : public testing::Test {
 protected:
  explicit RsiClientTest(bool hold_on = true)
      : codec{ethernet(hold_on)},
        client{{.nominal = kr210(),
                .ethernet = ethernet(hold_on),
                .cycle = 4ms,
                .timeout_cycles = 5,
                .axis_corr_limit_rad = 5 * kRadPerDeg},
               StreamPath{kr210(), {kStart}, 1.0},
               kFirstIpoc} {}

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

  double a1_deg() const { return client.axes()[0] * kDegPerRad; }

  rsi::SensorFrameCodec codec;
  RsiClient client;
};

class RsiClientWithoutHold : public RsiClientTest {
 protected:
  RsiClientWithoutHold() : RsiClientTest{false} {}
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
  EXPECT_EQ(answered(0), std::nullopt) << "a reply starts the count anew";
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
  EXPECT_EQ(answered(0.5, true), RsiEnd::Left);
}

TEST(StreamPath, VisitsItsPointsInALoopWithoutAJump) {
  const std::vector<JointVector> points{kStart, deg(25, -80, 95, 20, 45, -30), deg(15, -65, 75, -15, 50, 40)};
  StreamPath path{kr210(), points, 0.5};
  EXPECT_TRUE(path.moving());
  std::vector<double> nearest(points.size(), 1);
  JointVector before = path.position();
  EXPECT_EQ(before, kStart);
  for (int cycle = 0; cycle < 5000; ++cycle) {
    path.advance(4ms);
    const JointVector q = path.position();
    for (Eigen::Index i = 0; i < 6; ++i) {
      const double fastest = kr210().joints[static_cast<std::size_t>(i)].speed * 0.5 * 0.004;
      ASSERT_LE(std::abs(q[i] - before[i]), fastest * 1.000001) << "cycle " << cycle;
    }
    for (std::size_t k = 0; k < points.size(); ++k) nearest[k] = std::min(nearest[k], (q - points[k]).norm());
    before = q;
  }
  for (const double distance : nearest) EXPECT_LT(distance, 0.001);
}

TEST(StreamPath, StandsAtASinglePoint) {
  StreamPath path{kr210(), {kStart}, 1};
  path.advance(1s);
  EXPECT_EQ(path.position(), kStart);
  EXPECT_FALSE(path.moving());
}

TEST(TurnaroundHistogram, KnowsItsPercentilesAndItsSlowest) {
  TurnaroundHistogram histogram;
  EXPECT_EQ(histogram.percentile_us(0.99), 0);
  for (int us = 1; us <= 1000; ++us) histogram.record(std::chrono::microseconds{us});
  histogram.record(3s);
  EXPECT_EQ(histogram.percentile_us(0.5), 501);
  EXPECT_EQ(histogram.percentile_us(0.999), 1000);
  EXPECT_EQ(histogram.percentile_us(1.0), 3'000'000);
  EXPECT_EQ(histogram.max_us(), 3'000'000);
}

}  // namespace
}  // namespace truepose::sim
