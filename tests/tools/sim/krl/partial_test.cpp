// Programs of an archive: what of them is not known stops the program there, and nothing else.
#include <gmock/gmock.h>

#include "tests/tools/sim/krl/bench.hpp"

namespace truepose::sim::krl {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;

std::vector<Source> partial(std::vector<Source> sources) {
  for (Source& source : sources) source.is_partial = true;
  return sources;
}

std::vector<std::string> texts_of(const std::vector<Fault>& refusals) {
  std::vector<std::string> texts;
  for (const Fault& refusal : refusals) texts.push_back(refusal.text());
  return texts;
}

TEST(PartialPrograms, RunUpToAStatementThatIsNotKnownAndStopWithItsReason) {
  Bench bench(partial(program_of("N=1\nLASER_ON(3)\nN=2", "DECL INT N=0")));
  EXPECT_THAT(texts_of(bench.program.refusals), ElementsAre("p.src:3: the subprogram LASER_ON is not known"));
  const Interpreter& program = bench.start("P");
  EXPECT_EQ(program.fault().value().text(), "p.src:3: the subprogram LASER_ON is not known");
  EXPECT_EQ(bench.integer("N"), 1);
}

TEST(PartialPrograms, PassBranchesThatAreNotTakenWhateverStandsInThem) {
  Bench bench(partial(program_of(
      "IF N==1 THEN\nLASER_ON(3)\nENDIF\nWHILE N<2\nN=N+1\nENDWHILE\nSPLINE\nSPL X\nENDSPLINE\nN=9",
      "DECL INT N=0")));
  bench.start("P");
  EXPECT_EQ(bench.integer("N"), 2);
  EXPECT_EQ(bench.interpreters[0].fault().value().text(), "p.src:9: the name X is not known");
}

TEST(PartialPrograms, StopAtAConditionThatIsNotKnownOfEveryLoopAndBranch) {
  for (const std::string part : {"IF X THEN\nN=1\nELSE\nN=2\nENDIF", "WHILE X\nN=1\nENDWHILE",
                                 "FOR N=X TO 3\nENDFOR", "SWITCH X\nCASE 1\nN=1\nENDSWITCH"}) {
    Bench bench(partial(program_of(part, "DECL INT N=0")));
    EXPECT_EQ(bench.start("P").fault().value().text(), "p.src:2: the name X is not known") << part;
    EXPECT_EQ(bench.integer("N"), 0) << part;
    EXPECT_THAT(bench.program.refusals, SizeIs(1)) << part;
  }
  Bench bench(partial(program_of("REPEAT\nN=N+1\nUNTIL X", "DECL INT N=0")));
  EXPECT_EQ(bench.start("P").fault().value().text(), "p.src:4: the name X is not known");
  EXPECT_EQ(bench.integer("N"), 1);
}

TEST(PartialPrograms, AreStoppedAtTheCallOfASubprogramWhoseLoopsDoNotClose) {
  Bench bench(partial(program_of("N=1\nSUB()", "DECL INT N=0", "DEF SUB()\nLOOP\nN=2\nEND\n")));
  EXPECT_EQ(bench.start("P").fault().value().text(), "p.src:6: ENDLOOP is missing");
  EXPECT_EQ(bench.integer("N"), 1);
}

TEST(PartialPrograms, NameTheFileThatCouldNotBeRead) {
  Bench bench(partial({{"p.src", "DEF P()\nOTHER()\nEND\n"}, {"other.src", "DEF OTHER()\nN=?\nEND\n"}}));
  EXPECT_EQ(bench.start("P").fault().value().text(),
            "p.src:2: the subprogram OTHER is not known (other.src:2: the character ? does not belong here)");
}

TEST(PartialPrograms, NameTheDeclarationThatCouldNotBeRead) {
  Bench bench(partial(program_of("N=SEAM.LENGTH", "DECL INT N=0\nDECL SEAM_T SEAM={LENGTH 3}")));
  EXPECT_EQ(bench.start("P").fault().value().text(),
            "p.src:2: the name SEAM is not known (p.dat:3: the type SEAM_T is not known)");
}

TEST(PartialPrograms, StopAtSubprogramsOfPackagesThatTheArchiveHasNot) {
  Bench bench(partial(program_of("A20(4)", "EXT A20(INT:IN)")));
  EXPECT_EQ(
      bench.start("P").fault().value().text(),
      "p.src:2: the subprogram A20 is not known (p.dat:2: EXT: no file that is loaded has the subprogram A20)");
}

TEST(PartialPrograms, DeclareAgainWhatTheControllerHas) {
  Bench bench(partial(
      {{"$config.dat",
        "DEFDAT $CONFIG\nENUM MODE_OP T1,T2,AUT,EX,INVALID\nDECL INT RSIOK=0\n"
        "INT $ACT_BASE=3\nDECL CONST CHAR NAME[8]\nNAME[]=\"cell 4\"\nENDDAT"},
       {"$machine.dat", "DEFDAT $MACHINE PUBLIC\nREAL $LENGTH_A=350.5\nSIGNAL $COLL_ALARM_X FALSE\nENDDAT"},
       {"p.dat", "DEFDAT P\nDECL REAL A=0\nDECL BOOL B=TRUE\nENDDAT"},
       {"p.src", "DEF P()\nA=$LENGTH_A\nB=$COLL_ALARM_X\nEND\n"}}));
  EXPECT_THAT(bench.program.refusals, IsEmpty());
  bench.start("P");
  EXPECT_EQ(bench.real("A"), 350.5);
  EXPECT_EQ(bench.variable("B"), Value{false});
}

TEST(PartialPrograms, AreNotTakenTwice) {
  Bench bench(partial({{"A/p.src", "DEF P()\nN=1\nEND\n"},
                       {"A/p.dat", "DEFDAT P\nDECL INT N=0\nENDDAT"},
                       {"B/p.src", "DEF P()\nN=2\nEND\n"}}));
  EXPECT_THAT(texts_of(bench.program.refusals), ElementsAre("B/p.src:1: the subprogram P is declared twice"));
  bench.start("P");
  EXPECT_EQ(bench.integer("N"), 1);
}

}  // namespace
}  // namespace truepose::sim::krl
