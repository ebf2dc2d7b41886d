#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "tests/tools/sim/krl/bench.hpp"

namespace truepose::sim::krl {
namespace {

using Events = std::vector<std::string>;

const std::string kData = "DECL INT I=0\nDECL INT J=0\nDECL INT N=0";

/// A program whose subprogram WORK is interrupted by flag 1, which is raised after `after`.
Bench interrupted(const std::string& work, const std::string& handler, Time after = 400ms,
                  const std::string& declared = "") {
  Bench bench(program_of("INTERRUPT DECL 10 WHEN $FLAG[1]==TRUE DO HANDLER()\n" + declared +
                             "INTERRUPT ON 10\n$ADVANCE=0\nWORK()\nN=N+1\nWAIT FOR $FLAG[9]",
                         kData, "DEF WORK()\n" + work + "\nEND\nDEF HANDLER()\n" + handler + "\nEND\n"));
  bench.start("P");
  bench.run_for(after);
  bench.host.set("$FLAG[1]", true);
  bench.run_for(0s);
  return bench;
}

TEST(Interrupts, AreSeenByTheEdgeAndOnlyWhileSwitchedOn) {
  Bench bench(
      program_of("INTERRUPT DECL 10 WHEN $FLAG[1] DO HANDLER()\nWAIT FOR $FLAG[2]\nINTERRUPT ON 10\n"
                 "WAIT FOR $FLAG[3]\nINTERRUPT OFF 10\nWAIT FOR $FLAG[4]",
                 kData, "DEF HANDLER()\nI=I+1\nEND\n"));
  bench.start("P");
  const auto flag = [&](int number, bool value) {
    bench.host.set("$FLAG[" + std::to_string(number) + "]", value);
    bench.run_for(0s);
  };
  flag(1, true);
  EXPECT_EQ(bench.integer("I"), 0) << "not yet on";
  flag(2, true);
  EXPECT_EQ(bench.integer("I"), 0) << "true already when it was switched on";
  flag(1, false);
  flag(1, true);
  EXPECT_EQ(bench.integer("I"), 1);
  bench.run_for(1s);
  EXPECT_EQ(bench.integer("I"), 1) << "true still";
  flag(1, false);
  flag(3, true);
  flag(1, true);
  EXPECT_EQ(bench.integer("I"), 1) << "off again";
}

TEST(Interrupts, DisabledRememberTheEdge) {
  Bench bench(
      program_of("INTERRUPT DECL 10 WHEN $FLAG[1] DO HANDLER()\nINTERRUPT ON 10\nINTERRUPT DISABLE 10\n"
                 "WAIT FOR $FLAG[2]\nJ=1\nINTERRUPT ENABLE 10\nWAIT FOR $FLAG[3]",
                 kData, "DEF HANDLER()\nI=J\nJ=5\nEND\n"));
  bench.start("P");
  bench.host.set("$FLAG[1]", true);
  bench.run_for(0s);
  EXPECT_EQ(bench.integer("J"), 0);
  bench.host.set("$FLAG[2]", true);
  bench.run_for(0s);
  EXPECT_EQ(bench.integer("I"), 1);
  EXPECT_EQ(bench.integer("J"), 5);
}

TEST(Interrupts, OfAHigherPriorityGoFirstAndBreakIntoALower) {
  Bench bench(
      program_of("INTERRUPT DECL 20 WHEN $FLAG[1] DO LOW()\nINTERRUPT DECL 10 WHEN $FLAG[1] DO HIGH()\n"
                 "INTERRUPT DECL 5 WHEN $FLAG[2] DO HIGHEST()\nINTERRUPT ON\nWAIT FOR $FLAG[9]",
                 "DECL INT I=0",
                 "DEF LOW()\nI=I*10+3\nWAIT FOR $FLAG[3]\nI=I*10+4\nEND\nDEF HIGH()\nI=I*10+2\nEND\n"
                 "DEF HIGHEST()\nI=I*10+1\nEND\n"));
  bench.start("P");
  bench.host.set("$FLAG[1]", true);
  bench.run_for(0s);
  EXPECT_EQ(bench.integer("I"), 23);
  bench.host.set("$FLAG[2]", true);
  bench.run_for(0s);
  EXPECT_EQ(bench.integer("I"), 231);
  bench.host.set("$FLAG[3]", true);
  bench.run_for(0s);
  EXPECT_EQ(bench.integer("I"), 2314);
}

TEST(Interrupts, AreLookedAtBetweenStatementsToo) {
  Bench bench(
      program_of("INTERRUPT DECL 10 WHEN I==3 DO HANDLER()\nINTERRUPT ON 10\nFOR I=1 TO 5\nJ=J+1\nENDFOR",
                 kData, "DEF HANDLER()\nN=J\nEND\n"));
  bench.start("P");
  EXPECT_EQ(bench.integer("N"), 2);
}

TEST(Interrupts, LetTheArmMoveOnWhereTheyDoNotBrake) {
  Bench bench = interrupted("PTP {A1 1}\nJ=1", "I=1");
  EXPECT_EQ(bench.integer("I"), 1);
  EXPECT_EQ(bench.integer("J"), 0);
  bench.run_for(600ms);
  EXPECT_EQ(bench.integer("J"), 1);
  EXPECT_EQ(bench.host.log, (Events{"move 1", "1 is made"}));
}

TEST(Interrupts, LetWhatTheMainProgramWaitedForHappenInThem) {
  Bench bench(program_of("INTERRUPT DECL 10 WHEN $FLAG[1] DO HANDLER()\nINTERRUPT ON\nWAIT FOR J==2\nI=1",
                         kData, "DEF HANDLER()\nJ=2\nEND\n"));
  Interpreter& interpreter = bench.start("P");
  bench.host.set("$FLAG[1]", true);
  interpreter.run(bench.host.now);
  EXPECT_EQ(bench.integer("I"), 1) << "in the same turn";
}

TEST(Interrupts, DoNotLengthenAWaitingTime) {
  Bench bench = interrupted("WAIT SEC 1.0\nJ=1", "WAIT SEC 0.2\nI=1");
  bench.run_for(599ms);
  EXPECT_EQ(bench.integer("I"), 1);
  EXPECT_EQ(bench.integer("J"), 0);
  bench.run_for(1ms);
  EXPECT_EQ(bench.integer("J"), 1);
}

TEST(Interrupts, EndWithTheSubprogramThatDeclaredThem) {
  Bench bench(program_of("T()\n$FLAG[2]=TRUE\nINTERRUPT ON 11\nINTERRUPT ON 10", kData,
                         "DEF T()\nINTERRUPT DECL 10 WHEN $FLAG[1] DO HANDLER()\n"
                         "GLOBAL INTERRUPT DECL 11 WHEN $FLAG[1] DO HANDLER()\nINTERRUPT ON 10\nEND\n"
                         "DEF HANDLER()\nEND\n"));
  EXPECT_EQ(bench.start("P").fault()->text(), "p.src:5: the interrupt 10 is not declared");
}

TEST(Brake, WaitsUntilTheArmStandsAndThenGoesOn) {
  Bench bench = interrupted("PTP {A1 1}\nJ=1", "BRAKE\nI=1\nWAIT SEC 1.0\nI=2");
  EXPECT_EQ(bench.integer("I"), 0);
  bench.run_for(100ms);
  EXPECT_EQ(bench.integer("I"), 1);
  bench.run_for(1s);
  EXPECT_EQ(bench.integer("I"), 2);
  EXPECT_EQ(bench.integer("J"), 0);
  bench.run_for(600ms);
  EXPECT_EQ(bench.integer("J"), 1);
  EXPECT_EQ(bench.host.log, (Events{"move 1", "brake", "go on", "1 is made"}));
}

TEST(Brake, WithAllForceIsPassedToTheArm) {
  EXPECT_EQ(interrupted("PTP {A1 1}", "BRAKE F\nWAIT FOR FALSE").host.log, (Events{"move 1", "brake hard"}));
}

TEST(Brake, OutsideOfAnInterruptStopsTheProgram) {
  Bench bench(program_of("BRAKE"));
  EXPECT_EQ(bench.start("P").fault()->text(), "p.src:2: BRAKE stands outside of an interrupt program");
}

TEST(Brake, LetsTheInterruptMoveAndPlansTheRestAgain) {
  Bench bench = interrupted("PTP {A1 1}\nJ=1", "BRAKE\nPTP {A1 50}\nI=1");
  bench.run_for(100ms + 1s);
  EXPECT_EQ(bench.integer("I"), 1);
  EXPECT_EQ(bench.integer("J"), 0);
  bench.run_for(1s);
  EXPECT_EQ(bench.integer("J"), 1);
  EXPECT_EQ(bench.host.log,
            (Events{"move 1", "brake", "cancel", "move 2", "2 is made", "move 3", "3 is made"}));
  EXPECT_EQ(std::get<AxisTarget>(bench.host.moved[2].target).axes[0], 1);
}

TEST(Brake, MayComeAgainBehindAMotionOfTheInterrupt) {
  Bench bench = interrupted("PTP {A1 1}\nJ=1", "BRAKE\nPTP {A1 50}\nBRAKE\nI=1");
  bench.run_for(100ms + 1s);
  EXPECT_EQ(bench.integer("I"), 1);
  bench.run_for(1s);
  EXPECT_EQ(bench.integer("J"), 1);
  EXPECT_EQ(bench.host.log, (Events{"move 1", "brake", "cancel", "move 2", "2 is made", "brake", "go on",
                                    "move 3", "3 is made"}));
}

TEST(Brake, OfAnInterruptThatAnotherBrokeIntoHoldsTheArmStill) {
  Bench bench(program_of(
      "INTERRUPT DECL 20 WHEN $FLAG[1] DO LOW()\nINTERRUPT DECL 10 WHEN $FLAG[2] DO HIGH()\n"
      "INTERRUPT ON\n$ADVANCE=0\nPTP {A1 1}\nJ=1",
      kData, "DEF LOW()\nBRAKE\nWAIT FOR $FLAG[3]\nEND\nDEF HIGH()\nBRAKE\nPTP {A1 50}\nI=1\nEND\n"));
  bench.start("P");
  for (const int flag : {1, 2}) {
    bench.run_for(300ms);
    bench.host.set("$FLAG[" + std::to_string(flag) + "]", true);
  }
  bench.run_for(5s);
  EXPECT_EQ(bench.integer("I"), 1);
  EXPECT_EQ(bench.integer("J"), 0);
  bench.host.set("$FLAG[3]", true);
  bench.run_for(1s);
  EXPECT_EQ(bench.integer("J"), 1);
}

TEST(Brake, IsNeededBeforeAMotionOfAnInterrupt) {
  EXPECT_EQ(interrupted("WAIT FOR FALSE", "PTP {A1 1}").interpreters[0].fault()->text(),
            "p.src:13: a motion in an interrupt program needs BRAKE before it");
}

TEST(Resume, GoesOnBehindTheCallWithTheRestOfTheMotionDropped) {
  Bench bench = interrupted("DEEPER()\nJ=2\nEND\nDEF DEEPER()\nPTP {A1 1}\nJ=1", "BRAKE\nI=1\nRESUME\nI=2");
  EXPECT_EQ(bench.integer("N"), 0);
  bench.run_for(100ms);
  EXPECT_EQ(bench.integer("I"), 1);
  EXPECT_EQ(bench.integer("J"), 0);
  EXPECT_EQ(bench.integer("N"), 1);
  EXPECT_EQ(bench.host.log, (Events{"move 1", "brake", "cancel"}));
  EXPECT_EQ(bench.interpreters[0].state(), ProgramState::Active);
}

TEST(Resume, LeavesAWaitOfAnyKind) {
  for (const std::string wait : {"WAIT SEC 100", "WAIT FOR FALSE"}) {
    const Bench bench = interrupted(wait, "RESUME");
    EXPECT_EQ(bench.integer("N"), 1) << wait;
  }
}

TEST(Resume, NeedsACallBelowTheLevelOfTheInterrupt) {
  Bench bench(program_of("INTERRUPT DECL 10 WHEN $FLAG[1] DO HANDLER()\nINTERRUPT ON 10\nWAIT FOR FALSE", "",
                         "DEF HANDLER()\nRESUME\nEND\n"));
  bench.start("P");
  bench.host.set("$FLAG[1]", true);
  bench.run_for(0s);
  EXPECT_TRUE(
      bench.interpreters[0].fault()->text().starts_with("p.src:7: RESUME needs a running subprogram"));
}

TEST(Resume, DoesNotLeaveAnInterruptThatBrokeIntoTheLevelItself) {
  Bench bench(
      program_of("INTERRUPT DECL 20 WHEN $FLAG[1] DO LOW()\nINTERRUPT DECL 10 WHEN $FLAG[2] DO HIGH()\n"
                 "INTERRUPT ON\nWAIT FOR FALSE",
                 "", "DEF LOW()\nWAIT FOR FALSE\nEND\nDEF HIGH()\nRESUME\nEND\n"));
  bench.start("P");
  bench.host.set("$FLAG[1]", true);
  bench.run_for(0s);
  bench.host.set("$FLAG[2]", true);
  bench.run_for(0s);
  ASSERT_TRUE(bench.interpreters[0].fault());
  EXPECT_TRUE(bench.interpreters[0].fault()->text().starts_with("p.src:11: RESUME needs"));
}

TEST(Resume, FailsWhereTheAdvanceRunHasLeftTheSubprogram) {
  Bench bench(
      program_of("INTERRUPT DECL 10 WHEN $FLAG[1] DO HANDLER()\nINTERRUPT ON 10\n$ADVANCE=1\nWORK()\n"
                 "WAIT SEC 0",
                 kData, "DEF WORK()\nPTP {A1 1}\nEND\nDEF HANDLER()\nBRAKE\nRESUME\nEND\n"));
  bench.start("P");
  bench.run_for(100ms);
  bench.host.set("$FLAG[1]", true);
  bench.run_for(1s);
  ASSERT_TRUE(bench.interpreters[0].fault());
  EXPECT_TRUE(bench.interpreters[0].fault()->text().starts_with("p.src:13: RESUME needs"));
}

TEST(Resume, OutsideOfAnInterruptStopsTheProgram) {
  Bench bench(program_of("RESUME"));
  EXPECT_EQ(bench.start("P").fault()->text(), "p.src:2: RESUME stands outside of an interrupt program");
}

TEST(Resume, OutOfAFunctionInAnExpressionStopsTheProgram) {
  Bench bench(program_of("INTERRUPT DECL 10 WHEN $FLAG[1] DO HANDLER()\nINTERRUPT ON 10\nI=F()+1", kData,
                         "DEFFCT INT F()\nWAIT FOR FALSE\nRETURN 1\nENDFCT\nDEF HANDLER()\nRESUME\nEND\n"));
  bench.start("P");
  bench.host.set("$FLAG[1]", true);
  bench.run_for(0s);
  EXPECT_EQ(bench.interpreters[0].fault()->text(),
            "p.src:11: RESUME would return into the middle of an expression");
}

TEST(ProgramControl, DoesNotLetGoOfABrakedArm) {
  Bench bench = interrupted("PTP {A1 1}", "BRAKE\nWAIT FOR $FLAG[2]");
  bench.run_for(1s);
  bench.interpreters[0].stop();
  bench.interpreters[0].start();
  bench.run_for(1s);
  EXPECT_EQ(bench.host.log, (Events{"move 1", "brake"}));
  bench.host.set("$FLAG[2]", true);
  bench.run_for(2s);
  EXPECT_EQ(bench.host.log, (Events{"move 1", "brake", "go on", "1 is made"}));
}

}  // namespace
}  // namespace truepose::sim::krl
