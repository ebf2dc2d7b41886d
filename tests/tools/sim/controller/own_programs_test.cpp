// Programs of a cell's own, on a controller with the shipped files.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <map>
#include <optional>
#include <set>
#include <string>

#include "core/arm/forward.hpp"
#include "core/math/angles.hpp"
#include "tests/tools/sim/controller/demo_controller.hpp"
#include "tests/tools/sim/kr210.hpp"
#include "tools/sim/controller/controller.hpp"
#include "tools/sim/controller/controller_setup.hpp"

namespace truepose::sim {
namespace {

using namespace std::chrono_literals;
using testing::ElementsAre;
using testing::IsEmpty;
using Act = OperatorAct::Kind;

/// A program in addition to the shipped files, selected and started.
ControllerSetup with_program(const std::string& src) {
  ControllerSetup setup = controller_setup(demo_cell());
  setup.programs.push_back({"part.src", "DEF PART()\n" + src + "END\n"});
  setup.selected = "PART";
  setup.start = deg(0, -80, 105, 5, 60, 0);
  return setup;
}

TEST(Controller, MakesSplinesAndSwitchesOnTheirPath) {
  Controller controller{with_program(
      "$TOOL=$NULLFRAME\n$BASE=$NULLFRAME\nSLIN {X 1700,Y -200,Z 1200,A 0,B 0,C 180} WITH $VEL.CP=1.0\n"
      "SPLINE WITH $VEL.CP=0.2\nSPL {X 1650,Y -100,Z 1200}\n"
      "TRIGGER WHEN PATH=-50 DELAY=0 DO $TIMER_STOP[1]=FALSE\nSLIN {X 1650,Y 100,Z 1200}\nENDSPLINE\n"
      "$TIMER_STOP[1]=TRUE\nPTP {A1 $TIMER[1]/10.0}\n")};
  controller.advance(20s);
  EXPECT_THAT(controller.take_messages(), IsEmpty());
  EXPECT_EQ(controller.program().state, eki::ProgramState::Ended);
  EXPECT_EQ(controller.moves(), 3U) << "a block is one motion";
  EXPECT_NEAR(controller.axes()[0] * kDegPerRad, 35, 0.8) << "30 mm at 200 mm/s and 20 mm of braking";
}

TEST(Controller, LetsTheNamesOfTheScenarioPassTheAdvanceRun) {
  for (const bool passes : {false, true}) {
    ControllerSetup setup =
        with_program("$TOOL=$NULLFRAME\n$BASE=$NULLFRAME\nPTP {A1 20}\nMsgNotify(\"here\",\"x\")\n");
    if (passes) setup.pass_advance_run = {"MSGNOTIFY"};
    Controller controller{setup};
    controller.advance(100ms);
    EXPECT_EQ(controller.take_messages().empty(), !passes) << "the arm is still on its way";
    controller.advance(10s);
    EXPECT_EQ(controller.take_messages().empty(), passes);
  }
}

TEST(Controller, ShowsItsProgramsTheAnalogOutputsOfRsi) {
  Controller controller{with_program("WAIT FOR $ANOUT[3]<-0.2\nMsgNotify(\"low\",\"x\")\n")};
  controller.advance(100ms);
  EXPECT_THAT(controller.take_messages(), IsEmpty());
  controller.take({.monitor_axis = {}, .analog = {{3, -0.25}}});
  controller.advance(100ms);
  EXPECT_THAT(controller.take_messages(), ElementsAre("low"));
}

/// A program that is stopped leaves RSI on: the axes continue by its cycles.
TEST(Controller, IsJoggedUnderRsiOnceItsProgramIsStopped) {
  Controller controller{
      with_program("DECL INT ID\n$TOOL=$NULLFRAME\n$BASE=$NULLFRAME\nPTP $AXIS_ACT_MEAS\n"
                   "IF RSI_CREATE(\"truepose_rsi\",ID,TRUE)<>RSIOK THEN\nHALT\nENDIF\n"
                   "IF RSI_ON(#ABSOLUTE,#IPO_FAST)<>RSIOK THEN\nHALT\nENDIF\nRSI_MOVECORR()\n")};
  const auto pass = [&](int cycles) {
    for (int i = 0; i < cycles; ++i)
      static_cast<RsiProgram&>(controller).advance(kRsiCycle, controller.set_points(), kNoCorrection);
  };
  pass(500);
  ASSERT_TRUE(controller.is_on());
  controller.operate({.kind = Act::SetMode, .number = 1});
  pass(200);
  JointVector target = controller.axes();
  target[0] += 10 * kRadPerDeg;
  ASSERT_TRUE(controller.jog(target));
  pass(20);
  EXPECT_LT(std::abs(controller.axes()[0] - target[0]), 10 * kRadPerDeg) << "it is on its way";
  EXPECT_GT(std::abs(controller.axes()[0] - target[0]), 9 * kRadPerDeg) << "and does not jump";
  pass(2000);
  EXPECT_NEAR(controller.axes()[0], target[0], 1e-9);
  EXPECT_TRUE(controller.is_on());
}

TEST(Controller, TakesTimeForMotionsWithoutWay) {
  Controller controller{with_program(
      "$TOOL=$NULLFRAME\n$BASE=$NULLFRAME\n$SEN_PINT[100]=0\nLOOP\nPTP {A1 0,A2 -80,A3 105,A4 5,A5 60,A6 0}\n"
      "$SEN_PINT[100]=$SEN_PINT[100]+1\nENDLOOP\n")};
  controller.advance(2s);
  EXPECT_THAT(controller.take_messages(), IsEmpty());
  EXPECT_EQ(controller.program().state, eki::ProgramState::Active);
  const int motions = controller.sources().sen_pint(100);
  EXPECT_GT(motions, 100);
  EXPECT_LE(motions, 505) << "4 ms each at least";
}

constexpr const char* kSensorChannel = R"(<ETHERNETKRL>
  <CONFIGURATION>
    <EXTERNAL><TYPE>Client</TYPE></EXTERNAL>
    <INTERNAL><PORT>54600</PORT><ALIVE Set_Flag="1"/></INTERNAL>
  </CONFIGURATION>
  <RECEIVE><XML>
    <ELEMENT Tag="Sensor/Action" Type="INT"/>
    <ELEMENT Tag="Sensor/Frame" Type="FRAME"/>
    <ELEMENT Tag="Sensor" Set_Flag="4"/>
  </XML></RECEIVE>
  <SEND><XML>
    <ELEMENT Tag="Robot/Pos/@X"/><ELEMENT Tag="Robot/Pos/@Y"/><ELEMENT Tag="Robot/Pos/@Z"/>
    <ELEMENT Tag="Robot/Pos/@A"/><ELEMENT Tag="Robot/Pos/@B"/><ELEMENT Tag="Robot/Pos/@C"/>
    <ELEMENT Tag="Robot/Left"/>
  </XML></SEND>
</ETHERNETKRL>)";

TEST(Controller, ServesAChannelOfAnyNameWithFramesAndClearedBuffers) {
  ControllerSetup setup = with_program(
      "DECL EKI_STATUS RET\nDECL FRAME F\nRET=EKI_Init(\"Sensor\")\nRET=EKI_Open(\"Sensor\")\n"
      "WAIT FOR $FLAG[4]\nRET=EKI_GetFrame(\"Sensor\",\"Sensor/Frame\",F)\nF.X=F.X+1\n"
      "RET=EKI_SetFrame(\"Sensor\",\"Robot/Pos\",F)\nRET=EKI_ClearBuffer(\"Sensor\",\"Sensor\")\n"
      "RET=EKI_CheckBuffer(\"Sensor\",\"Sensor/Action\")\n"
      "RET=EKI_SetInt(\"Sensor\",\"Robot/Left\",RET.BUFF)\nRET=EKI_Send(\"Sensor\",\"Robot\")\n"
      "RET=EKI_Clear(\"Sensor\")\n");
  setup.eki_files.emplace("Sensor", kSensorChannel);
  Controller controller{setup};
  controller.advance(100ms);
  ASSERT_TRUE(controller.connect("Sensor"));
  controller.receive("Sensor",
                     "<Sensor><Action>7</Action>"
                     "<Frame X=\"1.5\" Y=\"2\" Z=\"3\" A=\"-4\" B=\"5\" C=\"6\"/></Sensor>");
  controller.advance(100ms);
  EXPECT_THAT(controller.take_messages(), IsEmpty());
  const auto documents = controller.take_documents();
  ASSERT_EQ(documents.size(), 1U);
  EXPECT_EQ(documents[0].text,
            "<Robot><Pos X=\"2.500000\" Y=\"2.000000\" Z=\"3.000000\" A=\"-4.000000\" B=\"5.000000\" "
            "C=\"6.000000\"></Pos><Left>0</Left></Robot>");
  EXPECT_THAT(controller.take_closed(), ElementsAre("Sensor")) << "EKI_Clear closes the client";
}

TEST(Controller, SetsParametersOfTheContextByTheirNames) {
  ControllerSetup setup = with_program(
      "DECL INT ID\nDECL REAL WAS,NOW\nIF RSI_CREATE(\"truepose_rsi\",ID,TRUE)<>RSIOK THEN\nHALT\nENDIF\n"
      "IF RSI_GETPUBLICPAR(ID,\"AxisCorr_1\",\"LowerLimA1\",WAS)<>RSIOK THEN\nHALT\nENDIF\n"
      "IF RSI_SETPUBLICPAR(ID,\"AxisCorr_1\",\"LowerLimA1\",-2.5)<>RSIOK THEN\nHALT\nENDIF\n"
      "IF RSI_SETPUBLICPAR(ID,\"AxisCorr_1\",\"Bad\",1)==RSIOK THEN\nHALT\nENDIF\n"
      "IF RSI_GETPUBLICPAR(ID,\"axiscorr_1\",\"lowerlima1\",NOW)<>RSIOK THEN\nHALT\nENDIF\n"
      "IF (WAS<>-5.0) OR (NOW<>-2.5) THEN\nHALT\nENDIF\n"
      "IF RSI_ON(#RELATIVE,#IPO_FAST)<>RSIOK THEN\nHALT\nENDIF\nRSI_MOVECORR()\n");
  setup.rsi_parameter = [](const std::string&, const RsiParameter& parameter) {
    return parameter.parameter == "Bad" ? std::nullopt : std::optional{-5.0};
  };
  Controller controller{setup};
  controller.advance(1s);
  ASSERT_TRUE(controller.rsi());
  ASSERT_EQ(controller.rsi()->parameters.size(), 1U);
  EXPECT_EQ(controller.rsi()->parameters[0].parameter, "LowerLimA1");
  EXPECT_EQ(controller.rsi()->parameters[0].value, -2.5);
  EXPECT_TRUE(controller.is_relative());
}

TEST(Controller, CorrectsNoPtpInTheCycleOf12Ms) {
  for (const bool ipo : {false, true}) {
    Controller controller{with_program(
        "DECL INT ID\n$TOOL=$NULLFRAME\n$BASE=$NULLFRAME\nPTP $AXIS_ACT_MEAS\nIF RSI_CREATE(\"truepose_rsi\",ID,TRUE)<>RSIOK THEN\nHALT\n"
        "ENDIF\nIF RSI_ON(#ABSOLUTE," +
        std::string{ipo ? "#IPO" : "#IPO_FAST"} +
        ")<>RSIOK THEN\nHALT\nENDIF\nPTP {A1 20}\nWAIT SEC 0.0\nLIN_REL {Z 50}\n")};
    std::map<std::uint64_t, std::set<bool>> corrected;  // by the motions made before
    for (int cycle = 0; cycle < 5000; ++cycle) {
      static_cast<RsiProgram&>(controller).advance(kRsiCycle, controller.set_points(), kNoCorrection);
      if (controller.is_on() && controller.moving())
        corrected[controller.moves()].insert(controller.corrects());
    }
    EXPECT_THAT(controller.take_messages(), IsEmpty());
    ASSERT_GE(corrected.size(), 2U);
    EXPECT_EQ(corrected.begin()->second, std::set{!ipo}) << "PTP";
    EXPECT_EQ(corrected.rbegin()->second, std::set{true}) << "LIN";
  }
}

/// The cell's own $config.dat has its tool 2 and its base 3.
TEST(Controller, MakesInlineFormsWithTheToolAndBaseOfTheirNumbers) {
  for (const std::string motion :
       {"PDAT_ACT=PDEFAULT\nFDAT_ACT=FP1\nBAS(#PTP_PARAMS,50)\nPTP XP1\n",
        "LDAT_ACT=LDEFAULT\nFDAT_ACT=FP1\nBAS(#CP_PARAMS,0.5)\nLIN XP1\n",
        "BAS(#TOOL,2)\nBAS(#BASE,3)\nLIN XP1\n",
        "SPTP XP1 WITH $VEL_AXIS[1]=SVEL_JOINT(50.0),$TOOL=STOOL2(FP1),$BASE=SBASE(FP1.BASE_NO),"
        "$IPO_MODE=SIPO_MODE(FP1.IPO_FRAME),$LOAD=SLOAD(FP1.TOOL_NO),$ACC_AXIS[1]=SACC_JOINT(PDEFAULT),"
        "$APO=SAPO_PTP(PDEFAULT),$GEAR_JERK[1]=SGEAR_JERK(PDEFAULT),"
        "$COLLMON_TOL_PRO[1]=USE_CM_PRO_VALUES(0)\n",
        "SLIN XP1 WITH $VEL=SVEL_CP(0.5,,LDEFAULT),$TOOL=STOOL2(FP1),$BASE=SBASE(FP1.BASE_NO),"
        "$IPO_MODE=SIPO_MODE(FP1.IPO_FRAME),$LOAD=SLOAD(FP1.TOOL_NO),$ACC=SACC_CP(LDEFAULT),"
        "$ORI_TYPE=SORI_TYP(LDEFAULT),$APO=SAPO(LDEFAULT),$JERK=SJERK(LDEFAULT)\n"}) {
    ControllerSetup setup =
        with_program("BAS(#INITMOV,0)\nPTP {A1 0,A2 -90,A3 90,A4 0,A5 45,A6 0}\n" + motion);
    setup.programs.push_back(
        {"part.dat",
         "DEFDAT PART\nDECL FDAT FP1={TOOL_NO 2,BASE_NO 3,IPO_FRAME #BASE,POINT2[] \" \"}\n"
         "DECL E6POS XP1={X 500.0,Y 100.0,Z 700.0,A 0.0,B 90.0,C 0.0,E1 0.0}\nENDDAT"});
    for (krl::Source& source : setup.programs) {
      if (source.file != "$config.dat") continue;
      source.text.insert(source.text.rfind("ENDDAT"),
                         "TOOL_DATA[2]={X 10.0,Y 20.0,Z 300.0,A 0.0,B 30.0,C 0.0}\n"
                         "BASE_DATA[3]={X 1000.0,Y -50.0,Z 500.0,A 10.0,B 0.0,C 0.0}\n");
    }
    Controller controller{setup};
    controller.advance(30s);
    EXPECT_THAT(controller.take_messages(), IsEmpty()) << motion;
    EXPECT_EQ(controller.program().state, eki::ProgramState::Ended) << motion;
    const Eigen::Isometry3d tool = pose_from_kuka({10, 20, 300}, {0, 30, 0});
    const Eigen::Isometry3d base = pose_from_kuka({1000, -50, 500}, {10, 0, 0});
    const Eigen::Isometry3d there = forward_kinematics(setup.nominal, controller.axes()) * tool;
    const Eigen::Isometry3d wanted = base * pose_from_kuka({500, 100, 700}, {0, 90, 0});
    EXPECT_LT((there.translation() - wanted.translation()).norm(), 1e-3) << motion;
    EXPECT_TRUE(there.linear().isApprox(wanted.linear(), 1e-6)) << motion;
  }
}

TEST(Controller, LoadsLinDataAsKss8WritesItIntoDataLists) {
  ControllerSetup setup =
      with_program("BAS(#INITMOV,0)\nLDAT_ACT=LCPDAT1\nFDAT_ACT=FP1\nBAS(#CP_PARAMS,0.5)\n");
  setup.programs.push_back(
      {"part.dat",
       "DEFDAT PART\nDECL FDAT FP1={TOOL_NO 0,BASE_NO 0,IPO_FRAME #BASE,POINT2[] \" \"}\n"
       "DECL LDAT LCPDAT1={VEL 2.0,ACC 100.0,APO_DIST 500.0,APO_FAC 50.0,AXIS_VEL 100.0,AXIS_ACC 100.0,"
       "ORI_TYP #VAR,CIRC_TYP #BASE,JERK_FAC 50.0,GEAR_JERK 100.0,EXAX_IGN 0,CB {AUX_PT {ORI #CONSIDER,"
       "E1 #CONSIDER,E2 #CONSIDER,E3 #CONSIDER,E4 #CONSIDER,E5 #CONSIDER,E6 #CONSIDER},TARGET_PT "
       "{ORI #INTERPOLATE,E1 #INTERPOLATE,E2 #INTERPOLATE,E3 #INTERPOLATE,E4 #INTERPOLATE,"
       "E5 #INTERPOLATE,E6 #INTERPOLATE}}}\nENDDAT"});
  Controller controller{setup};
  controller.advance(5s);
  EXPECT_THAT(controller.take_messages(), IsEmpty());
  EXPECT_EQ(controller.program().state, eki::ProgramState::Ended);
}

}  // namespace
}  // namespace truepose::sim
