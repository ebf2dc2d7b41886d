#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "tests/tools/sim/krl/bench.hpp"

namespace truepose::sim::krl {
namespace {

/// Runs P to its end. The data list declares I, J INT, R REAL, B BOOL, S CHAR[16].
Bench ran(const std::string& statements, const std::string& data = "", const std::string& more = "") {
  Bench bench(program_of(statements,
                         "DECL INT I=0\nDECL INT J=0\nDECL REAL R=0\nDECL BOOL B=FALSE\n"
                         "DECL CHAR S[16]\n" +
                             data,
                         more));
  const Interpreter& interpreter = bench.start("P");
  EXPECT_EQ(interpreter.state(), ProgramState::Ended)
      << (interpreter.fault() ? interpreter.fault()->text() : "it waits");
  return bench;
}

/// What stops P.
std::string fault_of(const std::string& statements, const std::string& data = "",
                     const std::string& more = "") {
  Bench bench(program_of(statements, "DECL INT I=0\nDECL REAL R=0\nDECL CHAR S[4]\n" + data, more));
  const Interpreter& interpreter = bench.start("P");
  return interpreter.fault() ? interpreter.fault()->text() : "";
}

TEST(Expressions, DivideIntegersWithoutRemainderAndMixedOnesAsReal) {
  EXPECT_EQ(ran("I=7/2").integer("I"), 3);
  EXPECT_EQ(ran("I=-7/2").integer("I"), -3);
  EXPECT_EQ(ran("R=7/2.0").real("R"), 3.5);
  EXPECT_EQ(ran("R=7/2").real("R"), 3.0);
}

TEST(Expressions, RoundARealThatBecomesAnInteger) {
  EXPECT_EQ(ran("I=2.5").integer("I"), 3);
  EXPECT_EQ(ran("I=-2.4").integer("I"), -2);
}

TEST(Expressions, HoldRealVariablesWith32Bits) {
  EXPECT_EQ(ran("R=0.1").real("R"), static_cast<double>(0.1f));
}

TEST(Expressions, TakeComparisonsLast) {
  EXPECT_EQ(ran("I=2+3*4-1").integer("I"), 13);
  EXPECT_TRUE(std::get<bool>(ran("B=1+1==2").variable("B")));
  // (1 B_OR 2) == 3, and NOT holds only what follows it.
  EXPECT_TRUE(std::get<bool>(ran("B=1 B_OR 2==3").variable("B")));
  EXPECT_TRUE(std::get<bool>(ran("B=NOT FALSE OR TRUE").variable("B")));
}

TEST(Expressions, KnowBitsAndCodedNumbers) {
  EXPECT_EQ(ran("I='H1F' B_AND 'B10110'").integer("I"), 22);
  EXPECT_EQ(ran("I='HFF' B_EXOR 'H0F'").integer("I"), 0xF0);
  EXPECT_EQ(ran("I=B_NOT 0").integer("I"), -1);
  EXPECT_EQ(ran("I='B 01 01'").integer("I"), 5) << "blanks within are allowed";
  EXPECT_EQ(ran("I='HFFFFFFFF'").integer("I"), -1);
}

TEST(Expressions, KnowAnglesInDegrees) {
  EXPECT_NEAR(ran("R=SIN(30)+COS(60)+TAN(45)").real("R"), 2, 1e-6);
  EXPECT_NEAR(ran("R=ATAN2(1,-1)").real("R"), 135, 1e-4);
  EXPECT_NEAR(ran("R=ACOS(0.5)+SQRT(9)+ABS(-2)").real("R"), 65, 1e-4);
}

TEST(Expressions, ChainFramesWithTheGeometricOperator) {
  const std::string frames =
      "DECL FRAME F={X 100,Y 0,Z 0,A 90,B 0,C 0}\nDECL FRAME G={X 10,Y 0,Z 5,A 0,B 0,C 30}\n";
  const Bench bench = ran("G=F:G\nR=G.Y\nF=INV_POS(F):F\nI=F.X", frames);
  EXPECT_NEAR(bench.real("R"), 10, 1e-5);
  EXPECT_EQ(bench.integer("I"), 0);
}

TEST(Expressions, StopTheProgramAtADivisionByZero) {
  EXPECT_EQ(fault_of("I=1\nI=I/(I-1)"), "p.src:3: a division by zero");
}

TEST(Expressions, StopTheProgramAtAVariableWithoutAValue) {
  EXPECT_EQ(fault_of("I=X", "DECL INT X"), "p.src:2: the variable X has no value");
  EXPECT_EQ(fault_of("DECL INT N[2,3]\nI=N[1,2]"), "p.src:3: the variable N[1,2] has no value");
  EXPECT_EQ(fault_of("DECL E6POS Q[2]\nQ[2].X=1\nR=Q[2].Y"), "p.src:4: the variable Q[2].Y has no value");
}

TEST(Variables, AreNotDistinguishedByCapitals) { EXPECT_EQ(ran("i = 4\nJ=I").integer("J"), 4); }

TEST(Variables, OfAStructureAreSetByComponentsAndAggregates) {
  const std::string data =
      "STRUC PART INT N,E6POS AT,CHAR NAME[8]\nDECL PART Q\nDECL E6AXIS H={A1 1,A2 -90}\n";
  const Bench bench =
      ran("Q={N 3,AT {X 1.5,S 'B110'},NAME[] \"ab\"}\nI=Q.N+Q.AT.S\nR=H.A2\nS[]=Q.NAME[]", data);
  EXPECT_EQ(bench.integer("I"), 9);
  EXPECT_EQ(bench.real("R"), -90);
  EXPECT_EQ(text_of(bench.variable("S")), "ab");
}

TEST(Variables, OfAnArrayBeginAtOneAndHaveUpToThreeIndices) {
  const Bench bench = ran("FOR I=1 TO 3\nM[I,2]=I*I\nENDFOR\nJ=M[3,2]+M[1,2]", "DECL INT M[3,2]");
  EXPECT_EQ(bench.integer("J"), 10);
}

TEST(Variables, RefuseAnIndexOutsideOfTheArray) {
  EXPECT_EQ(fault_of("I=3\nS[I+2]=\"x\""), "p.src:3: the index 5 lies outside of an array of 4");
  EXPECT_EQ(fault_of("I=0\nS[I]=\"x\""), "p.src:3: the index 0 lies outside of an array of 4");
}

TEST(Variables, OfOneModuleAreSeenByOthersWhereTheyAreGlobal) {
  std::vector<Source> sources = program_of("N=SHARED+1", "DECL INT N=0");
  sources.push_back({"q.dat", "DEFDAT Q PUBLIC\nGLOBAL INT SHARED=41\nINT OWN=1\nENDDAT"});
  Bench bench(sources);
  bench.start("P");
  EXPECT_EQ(bench.integer("N"), 42);
  sources[1].text = "DEF P()\nN=OWN\nEND";
  EXPECT_EQ(load_error(sources), "p.src:2: the name OWN is not known");
}

TEST(Variables, OfTheConfigurationAreSeenByAllModules) {
  std::vector<Source> sources = program_of("N=SHARED", "DECL INT N=0");
  sources.push_back({"$config.dat", "DEFDAT $CONFIG\nENUM COLOUR RED,GREEN\nDECL INT SHARED=7\nENDDAT"});
  Bench bench(sources);
  bench.start("P");
  EXPECT_EQ(bench.integer("N"), 7);
}

TEST(Variables, MayBeOtherNamesOfInputsAndOutputs) {
  Bench bench(program_of("GRIPPER=NOT READY", "SIGNAL GRIPPER $OUT[3]\nSIGNAL READY $IN[4]"));
  bench.start("P");
  EXPECT_TRUE(std::get<bool>(bench.host.variables.at("$OUT[3]")));
  EXPECT_EQ(load_error(program_of("", "SIGNAL FAR $IN[8193]")), "p.dat:2: the number of $IN is 1 to 8192");
}

TEST(Variables, MayBeNumbersOfSeveralInputsAndOutputs) {
  const std::string signals = "SIGNAL WORD $IN[3] TO $IN[6]\nSIGNAL TOOL_NO $OUT[1] TO $OUT[4]\nDECL INT I=0";
  Bench bench(program_of("I=WORD\nTOOL_NO=I+1", signals));
  bench.host.set("$IN[3]", true);
  bench.host.set("$IN[5]", true);
  bench.start("P");
  EXPECT_EQ(bench.integer("I"), 5) << "the lowest bit first";
  std::string bits;
  for (int i = 1; i <= 4; ++i)
    bits += std::get<bool>(bench.host.variables.at("$OUT[" + std::to_string(i) + "]")) ? '1' : '0';
  EXPECT_EQ(bits, "0110");
  Bench word(program_of("WORD=-2", "SIGNAL WORD $OUT[1] TO $OUT[32]"));
  word.start("P");
  EXPECT_FALSE(std::get<bool>(word.host.variables.at("$OUT[1]")));
  EXPECT_TRUE(std::get<bool>(word.host.variables.at("$OUT[32]")));
  Bench narrow(program_of("TOOL_NO=16", signals));
  EXPECT_EQ(narrow.start("P").fault().value().text(),
            "p.src:2: the number has more than the 4 bits of $OUT[1]");
}

TEST(Variables, OfSeveralInputsStandInOneArrayInOrder) {
  const std::string why =
      "p.dat:2: a signal goes from one element up to another of the same array, 32 at most";
  for (const std::string ends : {"$IN[8] TO $IN[1]", "$IN[1] TO $OUT[8]", "$IN[1] TO $IN[33]"})
    EXPECT_EQ(load_error(program_of("", "SIGNAL WORD " + ends)), why) << ends;
  EXPECT_EQ(load_error(program_of("", "SIGNAL WORD $TIMER[1] TO $TIMER[2]")),
            "p.dat:2: $TIMER is no array of BOOL or REAL of the controller");
}

TEST(Variables, TellTheirState) {
  const std::string statements =
      "IF VARSTATE(\"X\")==#DECLARED THEN\nI=1\nENDIF\nIF VARSTATE(\"NONE\")==#UNKNOWN THEN\nI=I+2\nENDIF\n"
      "IF VARSTATE(\"I\")==#INITIALIZED THEN\nI=I+4\nENDIF\n"
      "IF VARSTATE(\"$POS_ACT_MES\")<>#INITIALIZED THEN\nI=I+8\nENDIF";
  EXPECT_EQ(ran(statements, "DECL INT X").integer("I"), 15);
}

TEST(Texts, AreWrittenAppendedAndMeasured) {
  const Bench bench =
      ran("OFFSET=0\nSWRITE(S[],STATE,OFFSET,\"n=%d r=%.2f\",12,1.5)\nI=OFFSET\nJ=STRLEN(S[])\n"
          "B=STRCOMP(S[],\"N=12 R=1.50\",#NOT_CASE_SENS)",
          "DECL STATE_T STATE\nDECL INT OFFSET");
  EXPECT_EQ(text_of(bench.variable("S")), "n=12 r=1.50");
  EXPECT_EQ(bench.integer("I"), 11);
  EXPECT_EQ(bench.integer("J"), 11);
  EXPECT_TRUE(std::get<bool>(bench.variable("B")));
}

TEST(Texts, AreRead) {
  const std::string data =
      "DECL STATE_T STATE\nDECL INT OFFSET\nDECL CHAR WORD[8]\nDECL CHAR C\nDECL CHAR T[40]\nDECL REAL X\nDECL INT V[2]";
  const Bench bench = ran(
      "T[]=\"<part> 12;-3.5e1 x=1F +7z\"\nOFFSET=1\nSREAD(T[],STATE,OFFSET,\"%4s> %d;%f x=%x%2d%c\",WORD[],V[1],X,I,V[2],C)\n"
      "J=OFFSET\nB=(STATE.RET1==#CMD_OK) AND (STATE.HITS==6) AND (STATE.LENGTH==J-1)",
      data);
  EXPECT_EQ(text_of(bench.variable("WORD")), "part");
  EXPECT_EQ(bench.integer("I"), 0x1F);
  EXPECT_EQ(bench.integer("J"), 25);
  EXPECT_EQ(bench.real("X"), -35);
  EXPECT_EQ(std::get<char>(bench.variable("C")), 'z');
  EXPECT_EQ(std::get<Parts>(bench.variable("V")), (Parts{12, 7}));
  EXPECT_TRUE(std::get<bool>(bench.variable("B")));
}

TEST(Texts, ThatCannotBeReadAreReported) {
  const auto state = [](const std::string& text, const std::string& format, const std::string& variable) {
    const Bench bench =
        ran("T[]=\"" + text + "\"\nOFFSET=0\nSREAD(T[],STATE,OFFSET,\"" + format + "\"," + variable +
                ")\nI=STATE.HITS",
            "DECL STATE_T STATE\nDECL INT OFFSET\nDECL CHAR T[40]\nDECL REAL X\nDECL CHAR W[2]");
    const Parts parts = std::get<Parts>(bench.variable("STATE"));
    return std::get<Literal>(parts[0]).name + " " + std::to_string(bench.integer("I"));
  };
  EXPECT_EQ(state("12", "%d", "J"), "CMD_OK 1");
  EXPECT_EQ(state("12", "%d %f", "J,X"), "DATA_END 1");
  EXPECT_EQ(state("1 a", "%d %d", "J,I"), "FMT_ERR 1");
  EXPECT_EQ(state("1", "%f", "J"), "FMT_ERR 0") << "an INT is no REAL";
  EXPECT_EQ(state("abc", "%s", "W[]"), "FMT_ERR 0") << "too long";
  EXPECT_EQ(state("99999999999", "%d", "J"), "FMT_ERR 0");
  EXPECT_EQ(state("1 2", "%d %d", "J"), "FMT_ERR 1") << "no variable for it";
  EXPECT_EQ(state("0", "%d", "B"), "CMD_OK 1");
}

TEST(Texts, AreReadIntoVariables) {
  const std::string data = "DECL STATE_T STATE\nDECL INT OFFSET\nDECL FRAME F";
  EXPECT_EQ(load_error(program_of("SREAD(\"1\",STATE,OFFSET,\"%d\",1)", data)),
            "p.src:2: SREAD reads into variables");
  EXPECT_EQ(load_error(program_of("SREAD(\"1\",STATE,OFFSET,\"%d\",F)", data)),
            "p.src:2: SREAD cannot read FRAME");
  EXPECT_EQ(load_error(program_of("SREAD(\"1\",STATE,OFFSET)", data)),
            "p.src:2: SREAD takes a text, a state, an offset, a format and variables");
}

TEST(Texts, ThatDoNotFitAreReported) {
  const Bench bench = ran("OFFSET=0\nSWRITE(S[],STATE,OFFSET,\"%20d\",1)\nI=OFFSET\nB=STATE.RET1==#FMT_ERR",
                          "DECL STATE_T STATE\nDECL INT OFFSET");
  EXPECT_EQ(bench.integer("I"), 0);
  EXPECT_TRUE(std::get<bool>(bench.variable("B")));
  EXPECT_EQ(fault_of("S[]=\"abcde\""), "p.src:2: the text has 5 characters and the array 4");
}

TEST(Control, BranchesAndLoops) {
  EXPECT_EQ(ran("IF I==1 THEN\nJ=1\nELSE\nJ=2\nENDIF").integer("J"), 2);
  EXPECT_EQ(ran("FOR I=10 TO 1 STEP -3\nJ=J+I\nENDFOR").integer("J"), 22);
  EXPECT_EQ(ran("WHILE I<5\nI=I+2\nENDWHILE").integer("I"), 6);
  EXPECT_EQ(ran("REPEAT\nI=I+1\nUNTIL I>=3").integer("I"), 3);
  EXPECT_EQ(ran("LOOP\nI=I+1\nIF I==4 THEN\nEXIT\nENDIF\nENDLOOP").integer("I"), 4);
  EXPECT_EQ(ran("LOOP\nLOOP\nI=3\nGOTO OUT\nENDLOOP\nENDLOOP\nOUT:\nJ=I").integer("J"), 3);
  EXPECT_EQ(ran("AGAIN:\nI=I+1\nIF I<3 THEN\nGOTO AGAIN\nENDIF").integer("I"), 3);
}

TEST(Control, SwitchesOverNumbersConstantsAndLists) {
  const std::string by_number = "SWITCH I\nCASE 1\nJ=1\nCASE 2,3\nJ=23\nDEFAULT\nJ=9\nENDSWITCH";
  EXPECT_EQ(ran("I=3\n" + by_number).integer("J"), 23);
  EXPECT_EQ(ran("I=4\n" + by_number).integer("J"), 9);
  EXPECT_EQ(ran("C=#GREEN\nSWITCH C\nCASE #RED\nJ=1\nCASE #GREEN\nJ=2\nENDSWITCH",
                "ENUM COLOUR RED,GREEN\nDECL COLOUR C")
                .integer("J"),
            2);
}

TEST(Subprograms, TakeParametersByValueAndByReference) {
  const std::string more =
      "DEF ADD(WHAT:IN,TO:OUT)\nINT WHAT\nINT TO\nWHAT=WHAT+1\nTO=TO+WHAT\nEND\n"
      "DEFFCT INT TWICE(N:IN)\nINT N\nRETURN N*2\nENDFCT\n"
      "DEF FILL(T[]:OUT)\nCHAR T[]\nT[2]=\"z\"\nEND\n";
  const Bench bench = ran("J=5\nADD(I,J)\nI=TWICE(TWICE(J))\nS[]=\"abc\"\nFILL(S[])\nTWICE(1)", "", more);
  EXPECT_EQ(bench.integer("J"), 6);
  EXPECT_EQ(bench.integer("I"), 24);
  EXPECT_EQ(text_of(bench.variable("S")), "azc");
}

TEST(Subprograms, HaveFreshLocalDataInEachCall) {
  const std::string more =
      "DEFFCT INT FACTORIAL(N:IN)\nINT N\nDECL INT REST\nIF N<2 THEN\nRETURN 1\nENDIF\n"
      "REST=FACTORIAL(N-1)\nRETURN N*REST\nENDFCT\n";
  EXPECT_EQ(ran("I=FACTORIAL(6)", "", more).integer("I"), 720);
}

TEST(Subprograms, ThatCallThemselvesForEverStopTheProgram) {
  EXPECT_EQ(fault_of("P()"), "p.src:2: too many subprograms call one another");
}

TEST(Subprograms, ThatReturnNothingWhereTheyShouldStopTheProgram) {
  EXPECT_EQ(fault_of("I=F()", "", "DEFFCT INT F()\nENDFCT\n"), "p.src:5: the function ends without RETURN");
}

TEST(Host, RefusesWhatCannotBeWritten) {
  EXPECT_EQ(fault_of("$IN[3]=TRUE"), "p.src:2: $IN[3]: an input cannot be written");
}

TEST(Host, MayHaveNoTextToChange) {
  EXPECT_EQ(fault_of("STRCLEAR($ROBTRAFO[])"), "p.src:2: a text that STRCLEAR changes has no value");
}

TEST(Host, SeesAComponentOfASystemVariableChangeAlone) {
  Bench bench(program_of("$TOOL={X 1,Y 2,Z 3,A 0,B 0,C 0}\n$TOOL.Z=30\n$VEL_AXIS[2]=55"));
  bench.start("P");
  const Parts tool = std::get<Parts>(bench.host.variables.at("$TOOL"));
  EXPECT_EQ(number_of(tool[1]), 2);
  EXPECT_EQ(number_of(tool[2]), 30);
  EXPECT_EQ(std::get<std::int32_t>(bench.host.variables.at("$VEL_AXIS[2]")), 55);
}

TEST(Loops, WithoutAWaitLetTimePassAndTheOthersRun) {
  Bench bench(program_of("LOOP\nI=I+1\nENDLOOP", "DECL INT I=0"));
  const Interpreter& interpreter = bench.start("P");
  EXPECT_EQ(interpreter.next_change(), Time{1ms});
  const int after_a_turn = bench.integer("I");
  EXPECT_GT(after_a_turn, 100);
  bench.run_for(10ms);
  EXPECT_GT(bench.integer("I"), 5 * after_a_turn);
  EXPECT_EQ(interpreter.state(), ProgramState::Active);
  Bench empty(program_of("LOOP\nENDLOOP"));
  EXPECT_EQ(empty.start("P").state(), ProgramState::Active);
}

TEST(Calls, LeaveOutParametersAsKukasMsgLibDoes) {
  const std::string sub =
      "DEF SUB(A:IN,B:IN,C:OUT)\nINT A,B,C\nIF VARSTATE(\"A\")==#INITIALIZED THEN\nN=N+1\nENDIF\n"
      "IF VARSTATE(\"B\")==#INITIALIZED THEN\nN=N+10\nENDIF\nC=5\nEND\n";
  Bench bench(program_of("SUB(1,,I)\nSUB(,2)\nSUB(1)\nSUB()", "DECL INT N=0\nDECL INT I=0", sub));
  bench.start("P");
  EXPECT_EQ(bench.interpreters[0].state(), ProgramState::Ended);
  EXPECT_EQ(bench.integer("N"), 12);
  EXPECT_EQ(bench.integer("I"), 5);
}

TEST(Arrays, OfTextsAreSetByRowAndHandedOverWhole) {
  Bench bench(program_of("N=STRLEN(NAMES[2,])\nSUB(M[,])",
                         "DECL CHAR NAMES[3,24]\nNAMES[2,]=\"gripper\"\nDECL INT N=0\nDECL INT M[2,2]",
                         "DEF SUB(T[,]:OUT)\nINT T[,]\nT[2,1]=7\nN=N+T[2,1]\nEND\n"));
  bench.start("P");
  EXPECT_EQ(bench.integer("N"), 14);
}

TEST(Functions, ReturnTexts) {
  Bench bench(program_of(
      "N=STRLEN(NAME(TRUE))", "DECL INT N=0",
      "DEFFCT CHAR[32] NAME(LONG:IN)\nBOOL LONG\nCHAR T[32]\nT[]=\"spindle\"\nRETURN T[]\nENDFCT\n"));
  bench.start("P");
  EXPECT_EQ(bench.integer("N"), 7);
}

TEST(Characters, AreTheirCodes) {
  Bench bench(
      program_of("N=T[1]\nT[2]=N+1\nB=T[2]>66", "DECL CHAR T[2]\nT[]=\"A\"\nDECL INT N=0\nDECL BOOL B=TRUE"));
  bench.start("P");
  EXPECT_EQ(bench.integer("N"), 65);
  EXPECT_EQ(bench.variable("B"), Value{false});
  Bench wrong(program_of("T[1]=N", "DECL CHAR T[2]\nDECL INT N=300"));
  EXPECT_EQ(wrong.start("P").fault().value().text(), "p.src:2: the number is no character (0 to 255)");
}

TEST(RelativeMotions, GoAlongTheBaseOrTheTool) {
  Bench bench(
      program_of("LIN_REL {X 10} #TOOL\nLIN_REL {X 10}#BASE C_DIS\nPTP_REL {Z 5} #BASE\nLIN_REL {X 10}"));
  bench.start("P");
  bench.run_until_quiet();
  ASSERT_EQ(bench.host.moved.size(), 4u);
  EXPECT_TRUE(bench.host.moved[0].is_in_tool);
  for (std::size_t i = 1; i < 4; ++i) EXPECT_FALSE(bench.host.moved[i].is_in_tool) << i;
  EXPECT_EQ(load_error(program_of("LIN_REL {X 1} #WORLD")),
            "p.src:2: #BASE or #TOOL is expected instead of #WORLD");
}

}  // namespace
}  // namespace truepose::sim::krl
