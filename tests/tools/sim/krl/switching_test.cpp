// PULSE, $CYCFLAG and ON_ERROR_PROCEED.
#include <gmock/gmock.h>

#include "tests/tools/sim/krl/bench.hpp"

namespace truepose::sim::krl {
namespace {

using testing::HasSubstr;

bool is_on(const Bench& bench, const std::string& output) {
  const auto at = bench.host.variables.find(output);
  return at != bench.host.variables.end() && at->second == Value{true};
}

TEST(Pulses, EndByThemselvesWhateverTheProgramDoes) {
  Bench bench(program_of("PULSE($OUT[3],TRUE,0.5)\nHALT"));
  const Interpreter& program = bench.start("P");
  bench.run_for(400ms);
  EXPECT_TRUE(is_on(bench, "$OUT[3]"));
  bench.run_for(200ms);
  EXPECT_EQ(program.state(), ProgramState::Stopped) << "HALT";
  EXPECT_FALSE(is_on(bench, "$OUT[3]"));
}

TEST(Pulses, OfFalseEndWithTrueAndTakeOtherNamesOfOutputs) {
  Bench bench(program_of("PULSE(LAMP,FALSE,0.1)", "SIGNAL LAMP $OUT[4]"));
  bench.start("P");
  EXPECT_FALSE(is_on(bench, "$OUT[4]"));
  bench.run_until_quiet();
  EXPECT_TRUE(is_on(bench, "$OUT[4]"));
}

TEST(Pulses, GivenAgainLastFromThenOn) {
  Bench bench(program_of("PULSE($OUT[3],TRUE,0.5)\nWAIT SEC 0.4\nPULSE($OUT[3],TRUE,0.5)\nWAIT SEC 1"));
  bench.start("P");
  bench.run_for(800ms);
  EXPECT_TRUE(is_on(bench, "$OUT[3]"));
  bench.run_for(200ms);
  EXPECT_FALSE(is_on(bench, "$OUT[3]"));
}

TEST(Pulses, AreTriggeredOnThePath) {
  Bench bench(
      program_of("TRIGGER WHEN DISTANCE=1 DELAY=0 DO PULSE($OUT[3],TRUE,0.5)\nLIN {X 1}\nWAIT SEC 2"));
  bench.start("P");
  bench.run_for(900ms);
  EXPECT_FALSE(is_on(bench, "$OUT[3]"));
  bench.run_for(200ms);
  EXPECT_TRUE(is_on(bench, "$OUT[3]"));
  bench.run_for(1s);
  EXPECT_FALSE(is_on(bench, "$OUT[3]"));
}

TEST(Pulses, TakeAnOutputItsLevelAndATime) {
  EXPECT_EQ(load_error(program_of("PULSE($OUT[1],TRUE)")),
            "p.src:2: PULSE takes an output, its level and a time in seconds");
  EXPECT_EQ(load_error(program_of("PULSE(I,TRUE,1)", "DECL INT I=0")),
            "p.src:2: PULSE takes an output, a BOOL");
  Bench bench(program_of("PULSE($OUT[1],TRUE,5)"));
  EXPECT_EQ(bench.start("P").fault().value().text(), "p.src:2: the time of PULSE is 0.012 to 2 s");
}

TEST(CyclicalFlags, FollowTheirExpression) {
  Bench bench(program_of("$CYCFLAG[7]=$IN[1] AND NOT $IN[2]\nWAIT FOR $CYCFLAG[7]\nN=1", "DECL INT N=0"));
  bench.start("P");
  bench.run_for(100ms);
  EXPECT_EQ(bench.integer("N"), 0);
  bench.host.set("$IN[1]", true);
  bench.run_for(100ms);
  EXPECT_EQ(bench.integer("N"), 1);
}

TEST(CyclicalFlags, FireInterrupts) {
  Bench bench(
      program_of("$CYCFLAG[2]=$IN[1]\nINTERRUPT DECL 4 WHEN $CYCFLAG[2] DO SUB()\nINTERRUPT ON 4\nWAIT SEC 1",
                 "DECL INT N=0", "DEF SUB()\nN=N+1\nEND\n"));
  bench.start("P");
  bench.host.set("$IN[1]", true);
  bench.run_until_quiet();
  EXPECT_EQ(bench.integer("N"), 1);
}

TEST(CyclicalFlags, HaveANumberAndAConditionOfModuleData) {
  EXPECT_EQ(load_error(program_of("$CYCFLAG=TRUE")), "p.src:2: $CYCFLAG is set with its number: $CYCFLAG[1]");
  EXPECT_EQ(load_error(program_of("DECL BOOL B\n$CYCFLAG[1]=B")),
            "p.src:3: the cyclical flag uses B, which is local data; it may use module data and $ variables");
}

TEST(OnErrorProceed, PassesOverTheNextStatementAndKeepsItsNumber) {
  Bench bench(program_of("ON_ERROR_PROCEED\nI=J\nN=$ERR.NUMBER", "DECL INT I=5\nDECL INT J\nDECL INT N=0"));
  bench.host.set("$ERR", Parts{0, 0, 0, 0, std::string(24, '\0'), std::string(24, '\0')});
  const Interpreter& program = bench.start("P");
  EXPECT_EQ(program.state(), ProgramState::Ended);
  EXPECT_EQ(bench.integer("I"), 5);
  EXPECT_EQ(bench.integer("N"), 1422) << "KUKA's number of a variable without a value";
}

TEST(OnErrorProceed, IsForOneStatementAlone) {
  Bench bench(program_of("ON_ERROR_PROCEED\nI=1\nI=J", "DECL INT I=5\nDECL INT J"));
  EXPECT_EQ(bench.start("P").fault().value().text(), "p.src:4: the variable J has no value");
}

TEST(OnErrorProceed, IsNotForTheStatementsOfASubprogram) {
  Bench bench(program_of("ON_ERROR_PROCEED\nSUB()", "DECL INT J", "DEF SUB()\nINT I\nI=J\nEND\n"));
  EXPECT_THAT(bench.start("P").fault().value().text(), HasSubstr("the variable J has no value"));
}

}  // namespace
}  // namespace truepose::sim::krl
