#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "tests/tools/sim/krl/bench.hpp"

namespace truepose::sim::krl {
namespace {

using testing::HasSubstr;

const std::string kPoints =
    "DECL INT I=0\nDECL INT J=0\nDECL E6POS Q={X 1,Y 2,Z 3,A 0,B 90,C 0}\nDECL E6POS R={X 4,Y 5,Z 6,A 0,B 90,C 0}";

Bench splined(const std::string& statements) {
  Bench bench(program_of(statements, kPoints));
  bench.host.set("$ADVANCE", 3);
  bench.start("P");
  return bench;
}

std::string spline_error(const std::string& statements) {
  return load_error(program_of(statements, kPoints));
}

TEST(Splines, OfOneMotionAreThatMotion) {
  const Bench bench =
      splined("SPTP {A1 10} C_SPL\nSLIN Q\nSCIRC Q,R,CA 90.0\nSPTP_REL {A1 1}\nSLIN_REL {X 2}");
  ASSERT_EQ(bench.host.moved.size(), 4u) << "three wait behind the first";
  EXPECT_EQ(bench.host.moved[0].kind, MotionKind::Ptp);
  EXPECT_EQ(bench.host.moved[0].approximation, Approximation::Spl);
  EXPECT_EQ(bench.host.moved[1].kind, MotionKind::Lin);
  EXPECT_EQ(bench.host.moved[1].approximation, Approximation::None);
  EXPECT_EQ(bench.host.moved[2].kind, MotionKind::Circ);
  EXPECT_EQ(bench.host.moved[2].circle_angle_deg, 90);
  EXPECT_EQ(bench.host.moved[3].kind, MotionKind::PtpRel);
}

TEST(Splines, TakeABlockAsOneMotion) {
  Bench bench = splined("SPLINE\nSPL Q\nSLIN R\nSCIRC Q,R\nENDSPLINE C_SPL\nI=1\nWAIT SEC 0\nI=2");
  EXPECT_EQ(bench.integer("I"), 1);
  ASSERT_EQ(bench.host.moved.size(), 1u);
  const Motion& block = bench.host.moved[0];
  EXPECT_EQ(block.kind, MotionKind::Spline);
  EXPECT_EQ(block.approximation, Approximation::Spl);
  ASSERT_EQ(block.segments.size(), 3u);
  EXPECT_EQ(block.segments[0].kind, MotionKind::Spl);
  EXPECT_EQ(std::get<PoseTarget>(block.segments[0].target).pose[0], 1);
  EXPECT_EQ(block.segments[1].kind, MotionKind::Lin);
  EXPECT_EQ(std::get<PoseTarget>(block.segments[1].target).pose[0], 4);
  EXPECT_EQ(block.segments[2].via->pose[0], 1);
  bench.run_for(1s);
  EXPECT_EQ(bench.integer("I"), 2);
}

TEST(Splines, TakeABlockOfTheAxes) {
  const Bench bench = splined("PTP_SPLINE\nSPTP {A1 1}\nSPTP Q WITH $VEL_AXIS[1]=30\nENDSPLINE");
  ASSERT_EQ(bench.host.moved.size(), 1u);
  EXPECT_EQ(bench.host.moved[0].kind, MotionKind::PtpSpline);
  EXPECT_EQ(bench.host.moved[0].segments[0].velocity_percent[0], 100);
  EXPECT_EQ(bench.host.moved[0].segments[1].velocity_percent[0], 30);
}

TEST(With, HoldsForItsMotionAlone) {
  const Bench bench = splined(
      "$VEL.CP=0.5\n$TOOL={X 0,Y 0,Z 100,A 0,B 0,C 0}\n"
      "SLIN Q WITH $VEL.CP=0.1, $TOOL={X 0,Y 0,Z 200,A 0,B 0,C 0}, $TOOL.X=7, $ACC={CP 3.0,ORI1 1.0,ORI2 1.0}\nSLIN R");
  ASSERT_EQ(bench.host.moved.size(), 2u);
  const Motion &with = bench.host.moved[0], &without = bench.host.moved[1];
  EXPECT_FLOAT_EQ(static_cast<float>(*with.path_velocity_m_s), 0.1F);
  EXPECT_EQ(with.path_acceleration_m_s2, 3);
  EXPECT_EQ((*with.tool)[2], 200);
  EXPECT_EQ((*with.tool)[0], 7) << "what stands later counts";
  EXPECT_EQ(without.path_velocity_m_s, 0.5);
  EXPECT_EQ((*without.tool)[2], 100);
  EXPECT_FALSE(without.path_acceleration_m_s2);
}

TEST(With, OfABlockHoldsForItsSegmentsUnlessTheySayOtherwise) {
  const Bench bench =
      splined("SPLINE WITH $VEL.CP=0.25, $APO.CDIS=5\nSPL Q\nSPL R WITH $VEL.CP=0.5\nSPL Q\nENDSPLINE C_SPL");
  const Motion& block = bench.host.moved.at(0);
  EXPECT_EQ(block.approximation_distance_mm, 5);
  EXPECT_EQ(block.segments[0].path_velocity_m_s, 0.25);
  EXPECT_EQ(block.segments[1].path_velocity_m_s, 0.5);
  EXPECT_EQ(block.segments[2].path_velocity_m_s, 0.25);
}

TEST(With, SetsWhatMotionsTakeWithThem) {
  EXPECT_EQ(spline_error("SLIN Q WITH $OUT[1]=TRUE"),
            "p.src:2: WITH sets what motions take with them, such as $VEL.CP, not $OUT");
  EXPECT_EQ(spline_error("SLIN Q WITH I=1"),
            "p.src:2: WITH sets what motions take with them, such as $VEL.CP, not I");
  EXPECT_EQ(spline_error("SLIN Q WITH $VEL_AXIS[]=1"), "p.src:2: WITH sets one element of $VEL_AXIS");
  EXPECT_EQ(spline_error("SLIN Q WITH $NO_SUCH[1]=50"), "p.src:2: the name $NO_SUCH is not known");
  EXPECT_EQ(spline_error("LIN Q WITH $VEL.CP=1"), "p.src:2: the end of the line is expected before WITH");
  Bench bench = splined("I=9\nSPTP Q WITH $VEL_AXIS[I]=1");
  EXPECT_THAT(bench.interpreters[0].fault().value().text(), HasSubstr("the index 9 lies outside"));
}

TEST(Splines, TakeTheTimesOfTheirPartsAlong) {
  const Bench bench = splined(
      "SPLINE\nTIME_BLOCK START\nSPL Q\nTIME_BLOCK PART=30.5\nSPL R\nSPL Q\nTIME_BLOCK PART=69.5\n"
      "TIME_BLOCK END=2+2\nENDSPLINE");
  const Motion& block = bench.host.moved.at(0);
  EXPECT_EQ(block.segments[0].time_percent, 30.5);
  EXPECT_FALSE(block.segments[1].time_percent);
  EXPECT_EQ(block.segments[2].time_percent, 69.5);
  EXPECT_EQ(block.segments[2].time_s, 4);
  EXPECT_EQ(spline_error("SPLINE\nSPL Q\nTIME_BLOCK STOP\nENDSPLINE"),
            "p.src:4: START, PART or END is expected behind TIME_BLOCK");
  EXPECT_EQ(spline_error("SPLINE\nTIME_BLOCK PART=50\nSPL Q\nENDSPLINE"),
            "p.src:3: TIME_BLOCK stands behind the segments that it is about");
  EXPECT_EQ(spline_error("SPLINE\nSPL Q\nTIME_BLOCK END=5\nTIME_BLOCK PART=50\nENDSPLINE"),
            "p.src:5: TIME_BLOCK END comes once, behind all parts");
}

TEST(Splines, AreApproximatedWhateverStandsBehindThem) {
  const Bench bench = splined("SLIN Q C_DIS\nSPTP R C_PTP\nSLIN Q");
  EXPECT_EQ(bench.host.moved.at(0).approximation, Approximation::Spl);
  EXPECT_EQ(bench.host.moved.at(1).approximation, Approximation::Spl);
  EXPECT_EQ(bench.host.moved.at(2).approximation, Approximation::None);
}

TEST(Splines, TakeNothingElseIntoABlock) {
  EXPECT_EQ(spline_error("SPLINE\nSPL Q\nCONST_VEL START=50\nENDSPLINE"),
            "p.src:4: SPLINE takes SPL, SLIN, SCIRC, TRIGGER and TIME_BLOCK, not CONST_VEL");
  EXPECT_EQ(spline_error("SPLINE\nI=1\nENDSPLINE"),
            "p.src:3: SPLINE takes SPL, SLIN, SCIRC, TRIGGER and TIME_BLOCK, not I");
  EXPECT_EQ(spline_error("PTP_SPLINE\nSLIN Q\nENDSPLINE"),
            "p.src:3: PTP_SPLINE takes SPTP and TRIGGER, not SLIN");
  EXPECT_EQ(spline_error("SPLINE\nENDSPLINE"), "p.src:3: a segment is expected before ENDSPLINE");
  EXPECT_EQ(spline_error("SPLINE\nSPL Q\nTRIGGER WHEN PATH=0 DELAY=0 DO I=1\nENDSPLINE"),
            "p.src:5: a segment is expected before ENDSPLINE");
  EXPECT_EQ(spline_error("SPLINE\nSPL Q\nSPL R"), "p.src:2: ENDSPLINE is missing");
  EXPECT_EQ(spline_error("SPLINE\nSPL Q C_SPL\nENDSPLINE"),
            "p.src:3: the end of the line is expected before C_SPL");
  EXPECT_EQ(spline_error("SPL Q"), "p.src:2: the statement SPL is not known here");
  EXPECT_EQ(spline_error("SPLINE\nSPL {A1 1}\nENDSPLINE"),
            "p.src:3: SPL goes to a position or frame, not to axes");
  EXPECT_EQ(spline_error("SLIN Q C_NONE"), "p.src:2: the end of the line is expected before C_NONE");
  EXPECT_EQ(load_error({{"s.sub", "DEF S()\nPTP_SPLINE\nSPTP {A1 1}\nENDSPLINE\nEND\n"}}),
            "s.sub:3: a submit program must not move the arm");
}

}  // namespace
}  // namespace truepose::sim::krl
