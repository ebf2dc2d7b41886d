#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "tests/tools/sim/krl/bench.hpp"

namespace truepose::sim::krl {
namespace {

using Log = std::vector<std::string>;

/// P with I, J INT and the flags of the host.
Bench moving(const std::string& statements, const std::string& more = "") {
  Bench bench(
      program_of(statements, "DECL INT I=0\nDECL INT J=0\nDECL E6POS Q={X 1,Y 2,Z 3,A 0,B 90,C 0}", more));
  bench.host.set("$ADVANCE", 3);
  bench.start("P");
  return bench;
}

TEST(Motions, TakeTargetsAndVariablesWithThem) {
  const Bench bench = moving(
      "$VEL_AXIS[1]=20\n$ACC_AXIS[6]=30\n$VEL.CP=0.5\n$TOOL={X 0,Y 0,Z 100,A 0,B 0,C 0}\n"
      "PTP {A1 10,A2 -90} C_PTP\nLIN Q C_DIS\n$VEL_AXIS[1]=99\nPTP_REL {A3 5}");
  ASSERT_EQ(bench.host.moved.size(), 3u);
  const Motion& ptp = bench.host.moved[0];
  EXPECT_EQ(ptp.approximation, Approximation::Ptp);
  const AxisTarget& axes = std::get<AxisTarget>(ptp.target);
  EXPECT_EQ(axes.axes[0], 10);
  EXPECT_EQ(axes.axes[1], -90);
  EXPECT_FALSE(axes.axes[2]) << "left as it is";
  EXPECT_EQ(ptp.velocity_percent[0], 20);
  EXPECT_EQ(ptp.acceleration_percent[5], 30);
  EXPECT_EQ(ptp.path_velocity_m_s, 0.5);
  ASSERT_TRUE(ptp.tool);
  EXPECT_EQ((*ptp.tool)[2], 100);
  EXPECT_FALSE(ptp.base);
  EXPECT_EQ(bench.host.moved[1].kind, MotionKind::Lin);
  EXPECT_EQ(std::get<PoseTarget>(bench.host.moved[1].target).pose[4], 90);
  EXPECT_EQ(bench.host.moved[2].velocity_percent[0], 99);
  EXPECT_EQ(bench.host.moved[2].kind, MotionKind::PtpRel);
}

TEST(Motions, OnACircleHaveAPointOnTheWayAndAnAngle) {
  const Bench bench = moving("CIRC {X 10,Y 5},Q,CA 270.0 C_DIS");
  ASSERT_EQ(bench.host.moved.size(), 1u);
  EXPECT_EQ(bench.host.moved[0].via->pose[1], 5);
  EXPECT_EQ(bench.host.moved[0].circle_angle_deg, 270);
  EXPECT_EQ(bench.host.moved[0].approximation, Approximation::Dis);
}

TEST(AdvanceRun, OfZeroWaitsForTheEndOfEachMotion) {
  Bench bench = moving("$ADVANCE=0\nPTP {A1 1}\nI=1\nPTP {A1 2}\nI=2");
  EXPECT_EQ(bench.integer("I"), 0);
  bench.run_for(1500ms);
  EXPECT_EQ(bench.integer("I"), 1);
  bench.run_for(1s);
  EXPECT_EQ(bench.integer("I"), 2);
  EXPECT_EQ(bench.host.log, (Log{"move 1", "1 is made", "move 2", "2 is made"}));
}

TEST(AdvanceRun, GoesAheadAsManyMotionsAsAdvanceSays) {
  Bench bench = moving("$ADVANCE=2\nFOR I=1 TO 5\nPTP {A1 1}\nJ=I\nENDFOR");
  EXPECT_EQ(bench.host.moved.size(), 3u) << "one is made, two wait";
  EXPECT_EQ(bench.integer("J"), 2) << "it stands in the third motion";
  bench.run_for(1s);
  EXPECT_EQ(bench.host.moved.size(), 4u);
  EXPECT_EQ(bench.integer("J"), 3);
}

TEST(AdvanceRun, StopsWhereTheProgramMeetsTheOutsideWorld) {
  for (const std::string statement :
       {"$OUT[1]=TRUE", "I=$OV_PRO", "WAIT SEC 0.0", "WAIT FOR TRUE", "HALT", "IF $IN[1] THEN\nENDIF"}) {
    Bench bench = moving("I=5\nPTP {A1 1}\n" + statement + "\nJ=1");
    bench.host.set("$OV_PRO", 100);
    bench.run_for(999ms);
    EXPECT_EQ(bench.integer("J"), 0) << statement;
    EXPECT_EQ(bench.interpreters[0].state(), ProgramState::Active) << statement;
    bench.run_for(10ms);
    if (bench.interpreters[0].state() == ProgramState::Stopped) bench.interpreters[0].start();
    bench.run_for(1ms);
    EXPECT_EQ(bench.integer("J"), 1) << statement;
  }
}

TEST(AdvanceRun, IsNotStoppedBehindContinue) {
  for (const std::string statement : {"$OUT[1]=TRUE", "WAIT FOR TRUE", "IF $IN[1] THEN\nENDIF"}) {
    const Bench bench = moving("PTP {A1 1}\nCONTINUE\n" + statement + "\nJ=1");
    EXPECT_EQ(bench.integer("J"), 1) << statement;
  }
  const Bench bench = moving("PTP {A1 1}\nCONTINUE\n$OUT[1]=TRUE\nJ=1\n$OUT[1]=FALSE\nJ=2");
  EXPECT_EQ(bench.integer("J"), 1) << "CONTINUE holds for one statement";
}

TEST(AdvanceRun, EndsTheProgramWhenTheArmHasArrived) {
  Bench bench = moving("PTP {A1 1}");
  EXPECT_EQ(bench.interpreters[0].state(), ProgramState::Active);
  bench.run_for(1s);
  EXPECT_EQ(bench.interpreters[0].state(), ProgramState::Ended);
}

TEST(Waits, LastAsLongAsTheySay) {
  Bench bench = moving("WAIT SEC 0.5\nI=1\nWAIT FOR $FLAG[1]\nI=2");
  EXPECT_EQ(bench.interpreters[0].next_change(), Time{500ms});
  bench.run_for(499ms);
  EXPECT_EQ(bench.integer("I"), 0);
  bench.run_for(1ms);
  EXPECT_EQ(bench.integer("I"), 1);
  bench.run_for(10s);
  EXPECT_EQ(bench.integer("I"), 1);
  EXPECT_FALSE(bench.interpreters[0].next_change());
  bench.host.set("$FLAG[1]", true);
  bench.run_for(0s);
  EXPECT_EQ(bench.integer("I"), 2);
}

TEST(ProgramControl, StopsTheArmAndGoesOnWhereItStood) {
  Bench bench = moving("PTP {A1 1}\nWAIT SEC 0\nI=1");
  bench.run_for(400ms);
  bench.interpreters[0].stop();
  EXPECT_EQ(bench.interpreters[0].state(), ProgramState::Stopped);
  bench.run_for(10s);
  EXPECT_EQ(bench.integer("I"), 0);
  EXPECT_TRUE(bench.interpreters[0].start());
  bench.run_for(599ms);
  EXPECT_EQ(bench.integer("I"), 0);
  bench.run_for(1ms);
  EXPECT_EQ(bench.integer("I"), 1);
  EXPECT_EQ(bench.host.log, (Log{"move 1", "brake", "go on", "1 is made"}));
}

TEST(ProgramControl, ResetsLocalDataAndKeepsModuleData) {
  Bench bench(program_of("T()", "DECL INT I=0",
                         "DEF T()\nDECL INT N\nI=I+1\nIF VARSTATE(\"N\")==#DECLARED THEN\n"
                         "I=I+10\nENDIF\nN=1\nWAIT FOR $FLAG[1]\nEND\n"));
  Interpreter& interpreter = bench.start("P");
  EXPECT_EQ(bench.integer("I"), 11);
  interpreter.reset();
  EXPECT_EQ(interpreter.state(), ProgramState::Reset);
  EXPECT_EQ(interpreter.line(), 0);
  EXPECT_TRUE(interpreter.start());
  bench.run_for(0s);
  EXPECT_EQ(bench.integer("I"), 22);
}

TEST(ProgramControl, ResetDropsTheMotions) {
  Bench bench = moving("PTP {A1 1}\nPTP {A1 2}");
  bench.interpreters[0].reset();
  EXPECT_EQ(bench.host.log, (Log{"move 1", "move 2", "cancel"}));
}

TEST(ProgramControl, DeselectsAndSelectsAgain) {
  Bench bench = moving("WAIT FOR $FLAG[1]");
  Interpreter& interpreter = bench.interpreters[0];
  EXPECT_EQ(interpreter.line(), 2);
  interpreter.deselect();
  EXPECT_EQ(interpreter.state(), ProgramState::Free);
  EXPECT_FALSE(interpreter.start());
  EXPECT_EQ(interpreter.select("NOTHING").error(), "the program NOTHING is not known");
  EXPECT_TRUE(interpreter.select("p"));
  EXPECT_TRUE(interpreter.start());
}

TEST(ProgramControl, HaltWaitsForStart) {
  Bench bench = moving("I=1\nHALT\nI=2");
  EXPECT_EQ(bench.interpreters[0].state(), ProgramState::Stopped);
  EXPECT_EQ(bench.integer("I"), 1);
  EXPECT_TRUE(bench.interpreters[0].start());
  bench.run_for(0s);
  EXPECT_EQ(bench.integer("I"), 2);
  EXPECT_EQ(bench.host.log, Log{}) << "nothing moved, nothing was braked";
}

TEST(ProgramControl, AFaultBrakesIsShownAndNeedsAReset) {
  Bench bench = moving("PTP {A1 1}\nI=1/J");
  Interpreter& interpreter = bench.interpreters[0];
  ASSERT_TRUE(interpreter.fault());
  EXPECT_EQ(interpreter.fault()->text(), "p.src:3: a division by zero");
  EXPECT_EQ(bench.host.messages, Log{"p.src:3: a division by zero"});
  EXPECT_EQ(bench.host.log, (Log{"move 1", "brake"}));
  EXPECT_FALSE(interpreter.start());
  interpreter.reset();
  EXPECT_TRUE(interpreter.start());
}

TEST(Submit, RunsConcurrentlyWithTheRobotAndSharesItsData) {
  std::vector<Source> sources = program_of("WAIT FOR I==3\nJ=1\nPTP {A1 1}", "GLOBAL INT I=0\nDECL INT J=0");
  sources.push_back({"s.sub", "DEF S()\nLOOP\nI=I+1\nWAIT SEC 0.012\nENDLOOP\nEND\n"});
  Bench bench(sources);
  bench.start("P");
  bench.start("S", InterpreterKind::Submit);
  bench.run_for(20ms);
  EXPECT_EQ(bench.integer("J"), 0);
  bench.run_for(20ms);
  EXPECT_EQ(bench.integer("J"), 1);
}

TEST(Submit, MustNotMoveThroughAnotherModule) {
  std::vector<Source> sources = program_of("", "", "GLOBAL DEF GO()\nPTP {A1 1}\nEND\n");
  sources.push_back({"s.sub", "DEF S()\nGO()\nEND\n"});
  Bench bench(sources);
  EXPECT_EQ(bench.start("S", InterpreterKind::Submit).fault()->text(),
            "p.src:5: a submit program must not move the arm");
}

TEST(Submit, LeavesTheArmAloneAtResume) {
  std::vector<Source> sources = program_of("PTP {A1 1}\nWAIT SEC 0\nJ=1", "DECL INT J=0");
  sources.push_back(
      {"s.sub",
       "DEF S()\nINTERRUPT DECL 5 WHEN $FLAG[1] DO H()\nINTERRUPT ON 5\nT()\n$FLAG[2]=TRUE\nEND\n"
       "DEF T()\nWAIT FOR FALSE\nEND\nDEF H()\nRESUME\nEND\n"});
  Bench bench(sources);
  bench.start("P");
  bench.start("S", InterpreterKind::Submit);
  bench.host.set("$FLAG[1]", true);
  bench.run_for(1s);
  EXPECT_EQ(bench.interpreters[1].state(), ProgramState::Ended);
  EXPECT_EQ(bench.integer("J"), 1);
  EXPECT_EQ(bench.host.log, (Log{"move 1", "1 is made"}));
}

TEST(ExternalCalls, ThatAreNotFinishedAreAskedAgain) {
  Bench bench(program_of("OPEN(\"A\",I)", "DECL INT I=0"), "EXT OPEN(CHAR[]:IN,INT:OUT)");
  int asked = 0;
  bench.host.on_call = [&](ExternalCall& call) -> std::expected<CallResult, std::string> {
    EXPECT_EQ(call.is_first, ++asked == 1);
    EXPECT_EQ(text_of(call.arguments[0]), "A");
    call.arguments[1] = 7;
    return CallResult{.is_finished = asked == 4};
  };
  bench.start("P");
  EXPECT_EQ(bench.integer("I"), 0);
  bench.run_for(0s);
  EXPECT_EQ(bench.integer("I"), 0);
  bench.run_for(0s);
  EXPECT_EQ(bench.integer("I"), 7);
}

TEST(ExternalCalls, ThatFailStopTheProgram) {
  Bench bench(program_of("OPEN()"), "EXT OPEN()");
  EXPECT_EQ(bench.start("P").fault()->text(), "p.src:2: OPEN: nobody answers");
}

}  // namespace
}  // namespace truepose::sim::krl
