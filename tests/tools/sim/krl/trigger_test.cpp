#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "tests/tools/sim/krl/bench.hpp"

namespace truepose::sim::krl {
namespace {

using testing::HasSubstr;

const std::string kTriggerData =
    "DECL INT I=0\nDECL INT J=0\nDECL INT N=0\nDECL E6POS Q={X 1,Y 2,Z 3,A 0,B 90,C 0}";

/// P, whose motions take a second and are 1000 mm long.
Bench triggered(const std::string& statements, const std::string& more = "") {
  Bench bench(program_of(statements, kTriggerData, more));
  bench.host.set("$ADVANCE", 3);
  bench.start("P");
  return bench;
}

/// When I becomes 1, to the millisecond.
Time switched_at(Bench&& bench) {
  while (bench.integer("I") == 0 && bench.host.now < 10s) bench.run_for(1ms);
  return bench.host.now;
}

TEST(Triggers, SwitchAtTheBeginningOrTheEndOfTheNextMotion) {
  EXPECT_EQ(switched_at(triggered("PTP {A1 1}\nTRIGGER WHEN DISTANCE=0 DELAY=0 DO I=1\nPTP {A1 2}")),
            Time{1s});
  EXPECT_EQ(switched_at(triggered("PTP {A1 1}\nTRIGGER WHEN DISTANCE=1 DELAY=0 DO I=1\nPTP {A1 2}")),
            Time{2s});
}

TEST(Triggers, AreShiftedByTime) {
  EXPECT_EQ(switched_at(triggered("PTP {A1 1}\nTRIGGER WHEN DISTANCE=0 DELAY=250 DO I=1\nPTP {A1 2}")),
            Time{1250ms});
  EXPECT_EQ(switched_at(triggered("PTP {A1 1}\nTRIGGER WHEN DISTANCE=1 DELAY=-250 DO I=1\nPTP {A1 2}")),
            Time{1750ms});
}

TEST(Triggers, AreShiftedAlongThePath) {
  EXPECT_EQ(switched_at(triggered("TRIGGER WHEN PATH=-400 DELAY=0 DO I=1\nLIN Q")), Time{600ms});
  EXPECT_EQ(switched_at(triggered("TRIGGER WHEN PATH=300 ONSTART DELAY=50 DO I=1\nLIN Q")), Time{350ms});
}

TEST(Triggers, BelongToTheSegmentBehindThem) {
  EXPECT_EQ(
      switched_at(triggered("SPLINE\nSPL Q\nTRIGGER WHEN PATH=100 ONSTART DELAY=0 DO I=1\nSPL Q\nENDSPLINE")),
      Time{600ms});
}

TEST(Triggers, LetTheProgramGoOnAndEndBehindThem) {
  Bench bench = triggered("TRIGGER WHEN DISTANCE=1 DELAY=500 DO I=1\nPTP {A1 1}\nJ=1");
  EXPECT_EQ(bench.integer("J"), 1) << "the advance run goes past them";
  bench.run_for(1499ms);
  EXPECT_EQ(bench.interpreters[0].state(), ProgramState::Active);
  bench.run_for(1ms);
  EXPECT_EQ(bench.integer("I"), 1);
  EXPECT_EQ(bench.interpreters[0].state(), ProgramState::Ended);
}

TEST(Triggers, CallSubprogramsByTheirPriority) {
  Bench bench = triggered(
      "TRIGGER WHEN DISTANCE=1 DELAY=0 DO LATER(2) PRIO=-1\nTRIGGER WHEN DISTANCE=1 DELAY=0 DO FIRST() PRIO=10\n"
      "TRIGGER WHEN DISTANCE=1 DELAY=0 DO $OUT[7]=TRUE\nPTP {A1 1}\nWAIT FOR $FLAG[9]",
      "DEF LATER(A:IN)\nINT A\nI=I*10+A\nEND\nDEF FIRST()\nI=I*10+1\nIF $OUT[7] THEN\nJ=1\nENDIF\nEND\n");
  bench.run_for(1s);
  EXPECT_EQ(bench.integer("I"), 12);
  EXPECT_EQ(bench.integer("J"), 1) << "assignments go first";
}

TEST(Triggers, BreakIntoAProgramThatWaits) {
  Bench bench = triggered(
      "TRIGGER WHEN DISTANCE=1 DELAY=-100 DO $FLAG[1]=TRUE\nLIN Q\nCONTINUE\nWAIT FOR $FLAG[1]\nI=1");
  EXPECT_EQ(switched_at(std::move(bench)), Time{900ms});
}

TEST(Triggers, AreDroppedWithTheirMotions) {
  Bench bench(
      program_of("INTERRUPT DECL 10 WHEN $FLAG[1] DO HANDLER()\nINTERRUPT ON 10\nWORK()\nWAIT FOR $FLAG[9]",
                 kTriggerData,
                 "DEF WORK()\nTRIGGER WHEN DISTANCE=1 DELAY=0 DO I=1\nLIN Q\nWAIT SEC 0\nEND\n"
                 "DEF HANDLER()\nBRAKE\nRESUME\nEND\n"));
  bench.start("P");
  bench.run_for(500ms);
  bench.host.set("$FLAG[1]", true);
  bench.run_for(10s);
  EXPECT_EQ(bench.integer("I"), 0);
}

TEST(Triggers, OfAMotionThatIsPlannedAgainComeWithIt) {
  Bench bench(
      program_of("INTERRUPT DECL 10 WHEN $FLAG[1] DO HANDLER()\nINTERRUPT ON 10\n"
                 "TRIGGER WHEN DISTANCE=1 DELAY=0 DO I=J\nLIN Q\nWAIT FOR $FLAG[9]",
                 kTriggerData, "DEF HANDLER()\nBRAKE\nPTP {A1 5}\nJ=7\nEND\n"));
  bench.start("P");
  bench.run_for(500ms);
  bench.host.set("$FLAG[1]", true);
  bench.run_for(1900ms);
  EXPECT_EQ(bench.integer("I"), 0);
  bench.run_for(1s);
  EXPECT_EQ(bench.integer("I"), 7);
}

std::string trigger_error(const std::string& trigger) {
  return load_error(
      program_of(trigger + "\nLIN Q", kTriggerData, "DEF SUB()\nEND\nDEFFCT INT F()\nRETURN 1\nENDFCT\n"));
}

TEST(Triggers, AreRefusedWhereTheyCannotBe) {
  EXPECT_EQ(trigger_error("TRIGGER WHEN DISTANCE=2 DELAY=0 DO I=1"),
            "p.src:2: DISTANCE is 0, the start of the motion, or 1, its end");
  EXPECT_EQ(trigger_error("TRIGGER WHEN I==2 DO I=1"), "p.src:2: DISTANCE or PATH is expected");
  EXPECT_EQ(trigger_error("TRIGGER WHEN DISTANCE=1 DO I=1"), "p.src:2: DELAY is expected before DO");
  EXPECT_EQ(trigger_error("TRIGGER WHEN DISTANCE=1 DELAY=0 DO SUB()"),
            "p.src:2: a subprogram that is triggered needs PRIO");
  EXPECT_EQ(trigger_error("TRIGGER WHEN DISTANCE=1 DELAY=0 DO I=1 PRIO=5"),
            "p.src:2: the end of the line is expected before PRIO");
  EXPECT_EQ(trigger_error("TRIGGER WHEN DISTANCE=1 DELAY=0 DO I=F()"),
            "p.src:2: what a trigger sets cannot call F");
  EXPECT_EQ(trigger_error("TRIGGER WHEN DISTANCE=1 DELAY=0 DO PULSE($OUT[1],TRUE,0.1) PRIO=-1"),
            "p.src:2: the end of the line is expected before PRIO");
  EXPECT_EQ(trigger_error("DECL INT K\nTRIGGER WHEN DISTANCE=1 DELAY=0 DO K=1"),
            "p.src:3: the trigger uses K, which is local data; it may use module data and $ variables");
  EXPECT_EQ(trigger_error("SPLINE\nTRIGGER WHEN DISTANCE=1 DELAY=0 DO I=1\nSPL Q\nENDSPLINE"),
            "p.src:3: in a spline block PATH is expected");
  EXPECT_EQ(load_error({{"s.sub", "DEF S()\nTRIGGER WHEN DISTANCE=1 DELAY=0 DO $FLAG[1]=TRUE\nEND\n"}}),
            "s.sub:2: a submit program moves no arm that could trigger");
  Bench bench = triggered("TRIGGER WHEN DISTANCE=1 DELAY=0 DO SUB() PRIO=3\nLIN Q", "DEF SUB()\nEND\n");
  EXPECT_THAT(bench.interpreters[0].fault().value().text(),
              HasSubstr("p.src:2: PRIO is 1, 2, 4 to 39, 81 to 128, or -1"));
}

}  // namespace
}  // namespace truepose::sim::krl
