// What is read of a program: targets, tools and bases, and what is left alone.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <sstream>

#include "core/math/random.hpp"
#include "proto/krl/places.hpp"
#include "proto/krl/rewrite.hpp"
#include "tests/proto/krl_corpus.hpp"
#include "tests/trials.hpp"

namespace truepose::krl {
namespace {

using namespace std::string_view_literals;
using State = FrameValue::State;
using testing::ElementsAre;
using testing::HasSubstr;

constexpr std::string_view kConfig =
    "TOOL_DATA[1]={X 1,Y 0,Z 0,A 0,B 0,C 0}\nTOOL_DATA[2]={X 2,Y 0,Z 0,A 0,B 0,C 0}\n"
    "BASE_DATA[1]={X 10,Y 0,Z 0,A 0,B 0,C 0}\nBASE_DATA[2]={X 20,Y 0,Z 0,A 0,B 0,C 0}\n"
    "FDAT FHOME={TOOL_NO 2,BASE_NO 1,IPO_FRAME #BASE}\n"
    "E6POS GLOBAL_P={X 1,Y 2,Z 3,A 4,B 5,C 6,S 2,T 35}\n"
    "MACHINE_FRAME_DAT[2]={MACH_DEF_INDEX 1,PARENT[] \"T\",GEOMETRY[] \" \"}\n";
constexpr std::string_view kDat =
    "DECL E6POS XP1={X 1,Y 2,Z 3,A 4,B 5,C 6,S 2,T 35}\nDECL E6POS XP2={X 1,Y 2,Z 3,A 4,B 5,C 6,S 2,T 35}\n"
    "DECL FDAT FP1={TOOL_NO 1,BASE_NO 1,IPO_FRAME #BASE}\nDECL FDAT FP2={TOOL_NO 2,BASE_NO 0,IPO_FRAME "
    "#TCP}\n";

/// A program and the texts that it was read from.
struct Read {
  explicit Read(std::string src_in, std::string dat_in = std::string(kDat), StartFrames start = {})
      : src(std::string("DEF P()\n") += src_in),
        dat(std::move(dat_in)),
        program(read_program(program_text(src, dat, kConfig), start)) {}

  /// "tool base" of each target: x of known frames, else a letter.
  std::vector<std::string> frames() const {
    std::vector<std::string> result;
    for (const Step& step : program->steps) {
      if (step.point)
        result.push_back(text(step.tool) + " " + text(step.base) + (step.fixed_tool ? " fixed" : ""));
    }
    return result;
  }
  std::vector<std::string> left() const {
    std::vector<std::string> result;
    const auto line = [&](Spot spot) { return Places(spot.file == 0 ? src : dat).of(spot.at).line; };
    for (const LeftAlone& item : program->left) {
      std::ostringstream text;
      text << line(item.spot) << " " << item.name << (item.absolute ? "!" : "") << " "
           << item.why.message.what;
      if (item.why.because) text << " " << line(*item.why.because);
      result.push_back(text.str());
    }
    return result;
  }

  std::string src, dat;
  std::expected<Program, ProgramFault> program;

 private:
  std::string text(std::size_t frame) const {
    const FrameValue& value = program->frames[frame];
    const std::string letters = "?unCmwo";
    if (value.state == State::Known) return std::to_string(static_cast<int>(value.X.translation().x()));
    return letters.substr(static_cast<std::size_t>(value.state), 1) +
           (value.number ? std::to_string(value.number) : "");
  }
};

TEST(KrlProgram, TakesToolAndBaseFromEveryFormOfSettingThem) {
  const Read read(
      "LIN XP1\n"                                                     // nothing set
      "$TOOL={X 7,Y 0,Z 0,A 0,B 0,C 0}\n$BASE=$NULLFRAME\nLIN XP1\n"  // aggregates
      "BAS(#TOOL,1)\nbas (#base, 1 )\nLIN XP1\n"                      // by number
      "$TOOL=TOOL_DATA[2]\n$BASE=BASE_DATA[1]\nLIN XP1\n"             // of the tables
      "FDAT_ACT=FP1\nBAS(#CP_PARAMS,1)\nLIN XP1\n"                    // inline form
      "FDAT_ACT={TOOL_NO 2,BASE_NO 0,IPO_FRAME #BASE}\nLIN XP1\n"     // in place
      "FDAT_ACT=FHOME\nLIN XP1\n"                                     // of $config.dat
      "FDAT_ACT=FP2\nLIN XP1\n$IPO_MODE=#BASE\nLIN XP1\n"             // fixed tool, and not
      "BAS(#TOOL,9)\nBAS(#BASE,2)\nLIN XP1\n"                         // not given; moving
      "$TOOL=INVERSE_OF(3)\n$BASE.X=5\nLIN XP1\n"                     // computed
      "BAS(#INITMOV,0)\nLIN XP1\n");
  ASSERT_TRUE(read.program);
  EXPECT_THAT(read.frames(), ElementsAre("u u", "7 0", "1 10", "2 10", "1 10", "2 0", "2 10", "2 0 fixed",
                                         "2 0", "n9 m2", "C C", "u u"));
}

TEST(KrlProgram, AFrameThatTheProgramItselfWritesIsNotTheOneOfTheConfig) {
  const auto frames = [](const std::string& src) { return Read(src).frames(); };
  const std::string use = "BAS(#TOOL,1)\nBAS(#BASE,1)\nLIN XP1\n";
  EXPECT_THAT(frames("BASE_DATA[1]={X 1,Y 0,Z 0,A 0,B 0,C 0}\n" + use), ElementsAre("1 w1"));
  EXPECT_THAT(frames("tool_data[1].Z = 100.0\n" + use), ElementsAre("w1 10"));
  EXPECT_THAT(frames("BASE_DATA[3].X=1\n" + use), ElementsAre("1 10"));
  EXPECT_THAT(frames("BASE_DATA[n].X=1\n" + use), ElementsAre("1 w1"));
  EXPECT_THAT(frames("BASE_DATA[]=OTHERS[]\n" + use), ElementsAre("1 w1"));
  EXPECT_THAT(frames("TRIGGER WHEN PATH=1 DELAY=0 DO BASE_DATA[1].X=3\n" + use), ElementsAre("1 w1"));
  EXPECT_THAT(frames("TOOL_DATA[9].X=1\nBASE_DATA[1].X=1\n$TOOL=TOOL_DATA[9]\n$BASE=BASE_DATA[1]\nLIN XP1\n"
                     "FDAT_ACT=FP1\nLIN XP1\nBAS(#BASE,0)\nLIN XP1\n"),
              ElementsAre("w9 w1", "1 w1", "1 0"));
}

TEST(KrlProgram, AFrameWrittenAfterItsUseIsWrittenBeforeItTheNextTime) {
  const Read read("LOOP\nBAS(#TOOL,1)\nBAS(#BASE,1)\nLIN XP1\nBASE_DATA[1].Z=BASE_DATA[1].Z-50\nENDLOOP\n");
  EXPECT_THAT(read.frames(), ElementsAre("1 w1"));
}

TEST(KrlProgram, WhatIsSetOutOfTheOrderOfTheTextIsUnknownUntilItIsSetAgain) {
  const std::string use = "BAS(#TOOL,1)\nBAS(#BASE,1)\n", go = "LIN XP1\n", set = "BAS(#TOOL,2)\n";
  const auto frames = [&](const std::string& src, const std::string& routines = "") {
    return Read(use + src + "END\n" + routines).frames();
  };
  const std::string sets = "DEF Sets()\nBAS(#TOOL,2)\nEND\n",
                    through = "DEF Through( )\nIF X THEN\n$BASE=F(1)\nENDIF\nSETS()\nEND\n" + sets,
                    function = "DEFFCT INT F(N:IN)\nFDAT_ACT=FP2\nRETURN N\nENDFCT\n";
  EXPECT_THAT(frames("SETS ( )\n" + go + "BAS(#TOOL,1)\n" + go, sets), ElementsAre("o 10", "1 10"));
  EXPECT_THAT(frames("through()\n" + go, through), ElementsAre("o o"));
  EXPECT_THAT(frames("N=2*F(3)\n" + go, function), ElementsAre("o o"));
  EXPECT_THAT(frames("Q()\nOTHER()\n" + go, "DEF Q()\nBAS(#CP_PARAMS,1)\nEND\n"), ElementsAre("1 10"));

  EXPECT_THAT(frames("GOTO L\n" + set + "l:\n" + go), ElementsAre("o 10"));
  EXPECT_THAT(frames("GOTO L\nSETS()\nL:\n" + go, sets), ElementsAre("o 10"));
  EXPECT_THAT(frames("L:\n" + go + "$BASE=$NULLFRAME\n" + go + "GOTO L\n"), ElementsAre("1 o", "1 0"));
  EXPECT_THAT(frames("L:\n" + go + "GOTO L\n" + set + go), ElementsAre("1 10", "2 10"));
  EXPECT_THAT(frames("GOTO A\n" + set + "B:\n" + go + "GOTO C\nA:\n" + go + "GOTO B\nC:\n" + go),
              ElementsAre("o 10", "o 10", "o 10"));

  const std::string trigger = "TRIGGER WHEN PATH=1 DELAY=0 DO ",
                    interrupt = "INTERRUPT DECL 3 WHEN $IN[1] DO ";
  EXPECT_THAT(frames(go + trigger + "$BASE=$NULLFRAME\n" + go), ElementsAre("1 10", "1 o"));
  EXPECT_THAT(frames(trigger + "SETS() PRIO=-1\n" + go + "BAS(#TOOL,1)\n" + go, sets),
              ElementsAre("o 10", "1 10"));
  EXPECT_THAT(frames(trigger + "BAS(#TOOL,2) PRIO=-1\n" + go), ElementsAre("o 10"));
  EXPECT_THAT(frames(go + interrupt + "SETS()\nBAS(#TOOL,1)\n" + go, sets), ElementsAre("o 10", "o 10"));
  EXPECT_THAT(frames("GLOBAL " + interrupt + "$BASE.X=3\n" + go), ElementsAre("1 o"));
}

TEST(KrlProgram, FrameVariablesCountWhereTheyHaveOneValue) {
  const Read read(
      "$TOOL=F1\n$BASE=F2\nLIN XP1\nF2.X=1\n",
      std::string(kDat) + "FRAME F1={X 5,Y 0,Z 0,A 0,B 0,C 0}\nFRAME F2={X 6,Y 0,Z 0,A 0,B 0,C 0}\n");
  EXPECT_THAT(read.frames(), ElementsAre("5 C"));
}

TEST(KrlProgram, WithHoldsForItsOwnMotionAndASplineForItsSegments) {
  const Read read(
      "BAS(#TOOL,1)\nBAS(#BASE,1)\n"
      "SLIN XP1 WITH $VEL=SVEL_CP(0.3, ,L), $TOOL=STOOL2(FP2), $BASE=SBASE(FP2.BASE_NO), "
      "$IPO_MODE=SIPO_MODE(FP2.IPO_FRAME)\n"
      "SLIN XP1\n"
      "SPLINE WITH $BASE=$NULLFRAME\nSPL XP1\nSPL XP2 WITH $TOOL=TOOL_DATA[2]\nENDSPLINE\nPTP XP1\n"
      "SLIN XP1 WITH $BASE=EK(K_ROOT(FP1.BASE_NO),K_TYPE(FP1.BASE_NO),K_OFFS(FP1.BASE_NO))\n");
  EXPECT_THAT(read.frames(), ElementsAre("2 0 fixed", "1 10", "1 0", "2 0", "1 10", "1 C"));
}

TEST(KrlProgram, EveryRoutineStartsWithTheGivenFrames) {
  Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
  X.translation().x() = 3;
  const Read read("LIN XP1\nBAS(#TOOL,1)\nLIN XP1\nEND\nGLOBAL DEF Q()\nLIN XP1\nEND\n", std::string(kDat),
                  {X, X});
  EXPECT_THAT(read.frames(), ElementsAre("3 3", "1 3", "3 3"));
}

TEST(KrlProgram, SaysWhereTheToolChangesInABranch) {
  const Read read("BAS(#TOOL,1)\nIF X THEN\nBAS(#TOOL,2)\nENDIF\nLIN XP1\n");
  ASSERT_EQ(read.program->notes.size(), 1U);
  EXPECT_THAT(read.program->notes[0].text, HasSubstr("the tool changes inside a branch or loop"));
  EXPECT_TRUE(Read("LOOP\nBAS(#TOOL,1)\nLIN XP1\nBAS(#TOOL,1)\nENDLOOP\n").program->notes.empty());
}

TEST(KrlProgram, LeavesAloneWhatTheTextDoesNotTellOrNeedNotChange) {
  const Read read(
      "PTP XP1\nXP1.X=XP1.X+5\n"                       // 2, 3
      "LIN XP2:{X 1,Y 0,Z 0,A 0,B 0,C 0}\n"            // 4
      "LIN XP2+1\n"                                    // 5
      "LIN {X 100}\n"                                  // 6
      "PTP GRID[2]\nPTP SHIFT(XP2)\n"                  // 7, 8
      "PTP_REL {A1 5}\nLIN_REL XP2\n"                  // 9, 10
      "PTP XHOME\nPTP $AXIS_ACT\n"                     // 11, 12
      "PTP ELSEWHERE\nPTP elsewhere\nPTP GLOBAL_P\n",  // 13, 14
      std::string(kDat) + "E6POS GRID[2]\nGRID[1]={X 1,Y 2,Z 3,A 4,B 5,C 6}\n");
  ASSERT_TRUE(read.program);
  EXPECT_THAT(
      read.left(),
      ElementsAre(
          "2 XP1! is changed by the program 3", "4 ! the target is computed by the program",
          "5 ! the target is computed by the program",
          "6 ! component Y is missing: it keeps what the arm has then",
          "7 GRID[2]! is an element of an array or structure", "8 ! the target is computed by the program",
          "9  PTP_REL is relative to where the arm stands", "10  LIN_REL is relative to where the arm stands",
          "11 XHOME is a home position of the cell", "12 $AXIS_ACT is a variable of the controller",
          "13 ELSEWHERE! is declared in none of the files",
          "15 GLOBAL_P! is declared in $config.dat, for all programs", "2 XP2 no motion goes to it"));
}

TEST(KrlProgram, AVariableIsAPositionWhereTheProgramGivesItOneValue) {
  const std::string value = "{X 1,Y 2,Z 3,A 4,B 5,C 6}";
  const auto left = [&](const std::string& src) {
    return Read(std::string("DECL POS P\n") += src, "").left();
  };
  EXPECT_THAT(left("P=" + value + "\nPTP P\n"), ElementsAre());
  EXPECT_THAT(left("P=" + value + "\nPTP P\nP=" + value + "\n"),
              ElementsAre("4 P! is given another value by the program 5"));
  EXPECT_THAT(left("P=$POS_ACT\nPTP P\n"), ElementsAre("4 P! is computed by the program 3"));
  EXPECT_THAT(left("P={X 1}\nPTP P\n"),
              ElementsAre("4 P! component Y is missing: it keeps what the arm has then 3"));
  EXPECT_THAT(left("PTP P\n"), ElementsAre("3 P! gets its value while the program runs"));
  EXPECT_THAT(left("P=" + value + "\nSHIFT(1,P)\nPTP P\n"),
              ElementsAre("5 P! is handed to SHIFT, which may change it 4"));
  EXPECT_THAT(left("P=" + value + "\nQ=INVERSE(P)\nIF (P.X>1) THEN\nPTP P\nENDIF\n"), ElementsAre());
  EXPECT_THAT(left("P=" + value + "\nTRIGGER WHEN PATH=1 DELAY=0 DO P.X=3\nPTP P\n"),
              ElementsAre("5 P! is changed by the program 4"));
}

TEST(KrlProgram, LocalVariablesOfRoutinesDoNotMeet) {
  const Read read(
      "DECL POS XP1\nXP1={X 9,Y 2,Z 3,A 4,B 5,C 6}\nPTP xp1\nEND\nDEF Q()\nPTP XP1\nEND\nDEF R()\nPOS XP1\n"
      "XP1.X=2\nEND\n");
  ASSERT_EQ(read.program->points.size(), 2U);
  EXPECT_EQ(read.program->points[0].position.values[0].value, 9);
  EXPECT_EQ(read.program->points[1].position.values[0].value, 1);
}

TEST(KrlProgram, CirclesHaveTwoTargets) {
  const Read read(
      "CIRC XP1,XP2,CA 235.3 C_ORI\nSCIRC XP1, {X 1,Y 2,Z 3,A 4,B 5,C 6} WITH $CIRC_TYPE=#PATH\n");
  EXPECT_EQ(read.frames().size(), 4U);
  const Read fault("CIRC XP1\n");
  ASSERT_FALSE(fault.program);
  EXPECT_EQ(fault.program.error().spot.at, 8U);
}

TEST(KrlProgram, FaultsNameTheirFileAndByte) {
  const auto fault = [](const std::string& src, const std::string& dat) {
    return Read(src, dat).program.error();
  };
  EXPECT_EQ(fault("PTP {X 1,\n", "").spot.at, 12U);
  EXPECT_EQ(fault("PTP $POS_ACT:{X 1,\n", "").spot.at, 21U);
  EXPECT_EQ(fault("PTP\n", "").what, "PTP has too few targets; it goes to 1");
  const ProgramFault twice = fault("", "E6POS A\nPOS a\n");
  EXPECT_EQ(twice.spot.file, 1u);
  EXPECT_EQ(twice.spot.at, 12U);
  EXPECT_EQ(twice.what, "a is declared twice; remove one");
}

/// All that is read of a program, for comparison.
std::string printed(const Program& program) {
  std::ostringstream text;
  for (const Point& point : program.points) {
    text << point.name << "@" << point.position.spot.at;
    for (const Number& number : point.position.values) text << " " << number.value;
  }
  for (const Step& step : program.steps) {
    text << " " << step.spot.at << ":" << step.tool << "," << step.base;
    if (step.point) text << "," << *step.point;
  }
  for (const LeftAlone& left : program.left)
    text << " " << left.name << "@" << left.spot.at << left.why.message.what;
  return text.str();
}

TEST(KrlCorpus, ReadsTheSameTwiceAndIsWrittenBackAsItWas) {
  for (const auto& files : krl_corpus::all()) {
    const auto first = read_program(files.text(), {}), second = read_program(files.text(), {});
    ASSERT_TRUE(first && second) << files.name;
    EXPECT_EQ(printed(*first), printed(*second)) << files.name;
    EXPECT_GE(first->points.size(), 3U) << files.name;
    EXPECT_EQ(rewritten(files.src, {}), files.src);
    EXPECT_EQ(rewritten(files.dat, {}), files.dat);
  }
}

/// Each number is one of the text's, sign and all.
void expect_numbers_where_they_are_said(const Program& program, const ProgramText& text) {
  for (const Point& point : program.points) {
    const std::string_view in = text.files[point.position.spot.file].text;
    for (const Number& number : point.position.values) {
      ASSERT_LT(number.begin, number.end);
      ASSERT_LE(number.end, in.size());
    }
  }
}

std::string mutated(std::string text, Random& random) {
  constexpr std::string_view kNasty = "{}[](),:=.-+'\"#$&;\n\r\t E9\0\xff"sv;
  const auto place = [&] {
    return static_cast<std::size_t>(random.uniform(0, static_cast<double>(text.size())));
  };
  for (int k = 0; k < 1 + static_cast<int>(random.uniform(0, 4)) && !text.empty(); ++k) {
    const std::size_t at = place();
    switch (static_cast<int>(random.uniform(0, 4))) {
      case 0:
        text[at] = kNasty[random.next() % kNasty.size()];
        break;
      case 1:
        text.erase(at, 1 + random.next() % 20);
        break;
      case 2:
        text.insert(at, text.substr(place(), random.next() % 60));
        break;
      default:
        text.resize(at);
    }
  }
  return text;
}

TEST(KrlCorpus, SurvivesAnyMutationAndTruncation) {
  Random random(2024);
  int readable = 0;
  const auto read = [&](std::string_view given_src, std::string_view given_dat,
                        std::string_view given_config) {
    // Of their exact size on the heap, so that a sanitizer sees the first byte read past an end.
    const std::vector<char> src(given_src.begin(), given_src.end()), dat(given_dat.begin(), given_dat.end()),
        config(given_config.begin(), given_config.end());
    const ProgramText text =
        program_text({src.data(), src.size()}, {dat.data(), dat.size()}, {config.data(), config.size()});
    const auto program = read_program(text, {});
    if (!program) {
      EXPECT_FALSE(program.error().what.empty());
      return;
    }
    ++readable;
    expect_numbers_where_they_are_said(*program, text);
  };
  for (const auto& files : krl_corpus::all()) {
    for (int trial = 0; trial < 500 / share(); ++trial) {
      const std::string src = mutated(files.src, random), dat = mutated(files.dat, random),
                        config = mutated(files.config, random);
      read(src, files.dat, files.config);
      read(files.src, dat, config);
    }
    for (std::size_t length = 0; length < files.src.size(); length += 7)
      read(std::string_view(files.src).substr(0, length), files.dat, files.config);
    for (std::size_t length = 0; length < files.dat.size(); length += 7)
      read(files.src, std::string_view(files.dat).substr(0, length), files.config);
  }
  EXPECT_GT(readable, 2000 / share());
}

}  // namespace
}  // namespace truepose::krl
