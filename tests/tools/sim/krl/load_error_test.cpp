#include <gtest/gtest.h>

#include <string>

#include "tests/tools/sim/krl/bench.hpp"
#include "tests/tools/sim/krl/scripted_eki.hpp"

namespace truepose::sim::krl {
namespace {

/// What load() says of these statements of P, which begin in line 2.
std::string error_in(const std::string& statements, const std::string& more = "") {
  return load_error(program_of(
      statements, "DECL INT I=0\nDECL BOOL B=FALSE\nDECL INT M[3]\nDECL CHAR S[4]\nDECL E6POS Q", more));
}

std::string error_in_data(const std::string& data) { return load_error(program_of("", data)); }

TEST(LoadErrors, NameWhatIsUnknown) {
  EXPECT_EQ(error_in("I=1\nI=NOWHERE"), "p.src:3: the name NOWHERE is not known");
  EXPECT_EQ(error_in("I=$NO_SUCH"), "p.src:2: the name $NO_SUCH is not known");
  EXPECT_EQ(error_in("SOMETHING(1)"), "p.src:2: the subprogram SOMETHING is not known");
  EXPECT_EQ(error_in("DECL PART X"), "p.src:2: the type PART is not known");
  EXPECT_EQ(error_in("Q.V=1"), "p.src:2: E6POS has no component V");
  EXPECT_EQ(error_in("GOTO IN\nLOOP\nIN:\nENDLOOP"), "p.src:2: GOTO leads into a loop or branch");
  EXPECT_EQ(error_in("IF B THEN\nGOTO IN\nELSE\nIN:\nENDIF"), "p.src:3: GOTO leads into a loop or branch");
  EXPECT_EQ(error_in("GOTO THERE"), "p.src:2: the label THERE is not known");
  EXPECT_EQ(error_in("Q={X 1,W 2}"), "p.src:2: E6POS has no component W");
  EXPECT_EQ(error_in("IF VARSTATE(\"I\")==#SET THEN\nENDIF"),
            "p.src:2: the enumeration VAR_STATE has no #SET");
}

TEST(LoadErrors, TellTypesThatDoNotFit) {
  EXPECT_EQ(error_in("I=B"), "p.src:2: the variable I is INT and gets BOOL");
  EXPECT_EQ(error_in("B=1"), "p.src:2: the variable B is BOOL and gets INT");
  EXPECT_EQ(error_in("I=I+B"), "p.src:2: + does not go with INT and BOOL");
  EXPECT_EQ(error_in("IF I THEN\nENDIF"), "p.src:2: the condition of IF is BOOL and gets INT");
  EXPECT_EQ(error_in("IF I==B THEN\nENDIF"), "p.src:2: INT cannot be compared with BOOL");
  EXPECT_EQ(error_in("IF B<B THEN\nENDIF"), "p.src:2: BOOL has no order");
  EXPECT_EQ(error_in("I=M"), "p.src:2: an array as a whole is written with []");
  EXPECT_EQ(error_in("M[1.5]=1"), "p.src:2: an index is INT, not REAL");
  EXPECT_EQ(error_in("I[1]=1"), "p.src:2: an index stands behind a variable that is no array");
  EXPECT_EQ(error_in("S[1]=\"ab\""), "p.src:2: the variable S is CHAR and takes one character");
  EXPECT_EQ(error_in("PTP I"), "p.src:2: a motion cannot go to INT");
  EXPECT_EQ(error_in("LIN {A1 3}"), "p.src:2: LIN goes to a position or frame, not to axes");
  EXPECT_EQ(error_in("B=I==1 AND B==TRUE"), "p.src:2: AND does not go with INT and BOOL")
      << "comparisons come last: 1 AND B is one operand";
}

TEST(LoadErrors, CountParameters) {
  const std::string more = "DEF T(A:IN,C:OUT)\nINT A,C\nEND\n";
  EXPECT_EQ(error_in("T(1,I,2)", more), "p.src:2: T takes 2 parameters, not 3");
  EXPECT_EQ(error_in("T(1,2)", more), "p.src:2: parameter 2 of T is OUT and needs a variable");
  EXPECT_EQ(error_in("T(1,B)", more), "p.src:2: parameter 2 of T is INT and gets BOOL");
  EXPECT_EQ(error_in("T(B,I)", more), "p.src:2: parameter 1 of T is INT and gets BOOL");
}

TEST(LoadErrors, KeepWordsReserved) {
  EXPECT_EQ(error_in("", "DEF T(COMMAND:IN)\nINT COMMAND\nEND\n"), "")
      << "KUKA's BAS has a parameter COMMAND, and a package of KUKA's an ENUM of that name";
  EXPECT_EQ(error_in_data("STRUC FRAME INT N"), "p.dat:2: the type FRAME is declared twice");
  EXPECT_EQ(error_in_data("DECL INT WAIT"), "p.dat:2: WAIT is a word of KRL and cannot be a name");
  EXPECT_EQ(error_in_data("DECL INT ABCDEFGHIJKLMNOPQRSTUVWXY"),
            "p.dat:2: ABCDEFGHIJKLMNOPQRSTUVWXY has more than 24 characters");
}

TEST(LoadErrors, RefuseWhatIsNotKnownHere) {
  EXPECT_EQ(error_in("CIRC_REL Q,Q"), "p.src:2: the statement CIRC_REL is not known here");
  EXPECT_EQ(error_in("PTP Q C_NONE"), "p.src:2: the end of the line is expected before C_NONE");
  EXPECT_EQ(error_in("I=1 I=2"), "p.src:2: the end of the line is expected before I");
  EXPECT_EQ(error_in("I=1\nDECL INT K"), "p.src:3: declarations stand before the first statement");
  EXPECT_EQ(error_in("DECL INT K=1"),
            "p.src:2: a declaration in a program has no initial value; it belongs into the data list");
  EXPECT_EQ(error_in_data("DECL INT N=I"), "p.dat:2: an initial value is constant");
  EXPECT_EQ(error_in("DECL CONST INT K"), "p.src:2: local data is neither GLOBAL nor CONST");
  EXPECT_EQ(error_in("EXIT"), "p.src:2: EXIT stands in no loop");
}

TEST(LoadErrors, FindWhatIsNotClosed) {
  EXPECT_EQ(error_in("LOOP\nI=1"), "p.src:2: ENDLOOP is missing");
  EXPECT_EQ(error_in("IF B THEN\nI=1"), "p.src:2: ENDIF is missing");
  EXPECT_EQ(error_in("I=(1+2"), "p.src:2: ) is expected at the end of the line");
  EXPECT_EQ(error_in("S[]=\"ab"), "p.src:2: the text is not closed in its line");
  EXPECT_EQ(load_error({{"p.src", "DEF P()\n"}}), "p.src:1: END of P is missing");
  EXPECT_EQ(load_error({{"p.src", "DEF P()\nDEF Q()\nEND\n"}}), "p.src:2: END of P is missing");
  EXPECT_EQ(load_error({{"p.dat", "DEFDAT P\nDECL INT I\n"}}), "p.dat:2: ENDDAT is missing");
  EXPECT_EQ(load_error({{"p.txt", ""}}), "p.txt:0: a file of KRL ends in .src, .sub or .dat");
}

TEST(LoadErrors, FindNamesDeclaredTwice) {
  EXPECT_EQ(error_in_data("DECL INT N\nDECL REAL N"), "p.dat:3: N is declared twice");
  EXPECT_EQ(error_in("DECL INT K\nDECL REAL K"), "p.src:3: K is declared twice");
  EXPECT_EQ(error_in("", "DEF T()\nEND\nDEF T()\nEND\n"), "p.src:6: the subprogram T is declared twice");
}

TEST(LoadErrors, KeepLocalDataAndCallsOutOfInterrupts) {
  EXPECT_EQ(error_in("DECL INT K\nINTERRUPT DECL 3 WHEN K==1 DO T()", "DEF T()\nEND\n"),
            "p.src:3: the interrupt uses K, which is local data; it may use module data and $ variables");
  EXPECT_EQ(
      error_in("INTERRUPT DECL 3 WHEN F() DO T()", "DEF T()\nEND\nDEFFCT BOOL F()\nRETURN TRUE\nENDFCT\n"),
      "p.src:2: the condition of an interrupt cannot call F");
}

TEST(LoadErrors, LetNoSubmitProgramMoveTheArm) {
  EXPECT_EQ(load_error({{"s.sub", "DEF S()\nPTP {A1 1}\nEND\n"}}),
            "s.sub:2: a submit program must not move the arm");
  EXPECT_EQ(load_error({{"s.sub", "DEF S()\nBRAKE\nEND\n"}}),
            "s.sub:2: a submit program must not brake the arm");
}

TEST(LoadErrors, FindAnInitialValueThatDoesNotFit) {
  EXPECT_EQ(error_in_data("DECL CHAR T[3]\nT[]=\"abcd\""),
            "p.dat:3: the text has 4 characters and the array 3");
  EXPECT_EQ(error_in_data("DECL INT N[99999999]"), "p.dat:2: the variable is too large");
}

TEST(LoadErrors, KeepTheControllerOutOfDataLists) {
  EXPECT_EQ(error_in_data("$OV_PRO=50"), "p.dat:2: $OV_PRO is the controller's and gets no initial value");
  EXPECT_EQ(error_in_data("DECL INT N[3]\nN[$OV_PRO]=1"), "p.dat:3: an index in a data list is constant");
  EXPECT_EQ(error_in_data("SIGNAL G $OUT[1]\nG=TRUE"),
            "p.dat:3: G is the controller's and gets no initial value");
  EXPECT_EQ(error_in_data("DECL INT $MINE"),
            "p.dat:2: $MINE begins with $, as the controller's own variables do");
}

TEST(LoadErrors, DoNotFollowBracketsWithoutEnd) {
  EXPECT_EQ(error_in("I=" + std::string(10000, '(')), "p.src:2: the expression is nested too deeply");
  EXPECT_EQ(error_in("I=" + std::string(10000, '-')), "p.src:2: the expression is nested too deeply");
  std::string loops;
  for (int i = 0; i < 1000; ++i) loops += "LOOP\n";
  EXPECT_EQ(error_in(loops), "p.src:62: loops and branches are nested too deeply");
}

TEST(ShippedPrograms, AreWhatAControllerLoads) { EXPECT_EQ(load_error(shipped_sources()), ""); }

}  // namespace
}  // namespace truepose::sim::krl
