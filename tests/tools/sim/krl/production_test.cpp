#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "tests/tools/sim/krl/bench.hpp"

namespace truepose::sim::krl {
namespace {

// What $config.dat and the option packages declare for inline forms, as far as the program needs it.
constexpr const char* kWeldConfiguration = R"krl(&ACCESS RVP
DEFDAT  $CONFIG
ENUM IPO_M_T NONE,TCP,BASE
STRUC FDAT INT TOOL_NO,BASE_NO,IPO_M_T IPO_FRAME,CHAR POINT2[24],BOOL TQ_STATE
STRUC PDAT REAL VEL,ACC,APO_DIST
STRUC LDAT REAL VEL,ACC,APO_DIST
DECL PDAT PDAT_ACT
DECL LDAT LDAT_ACT
DECL FDAT FDAT_ACT
DECL FDAT FHOME={TOOL_NO 0,BASE_NO 0,IPO_FRAME #NONE}
DECL PDAT PDEFAULT={VEL 100.0,ACC 100.0,APO_DIST 100.0}
E6AXIS XHOME={A1 0.0,A2 -90.0,A3 90.0,A4 0.0,A5 0.0,A6 0.0,E1 0.0,E2 0.0,E3 0.0,E4 0.0,E5 0.0,E6 0.0}
FRAME TOOL_DATA[16]
TOOL_DATA[1]={X 0.0,Y 0.0,Z 120.5,A 0.0,B 0.0,C 0.0}
ENDDAT
)krl";

constexpr const char* kWeldData = R"krl(&ACCESS RVP
&REL 3
DEFDAT  WELD PUBLIC
;FOLD EXTERNAL DECLARATIONS;%{PE}%MKUKATPBASIS,%CEXT,%VCOMMON,%P
EXT  BAS (BAS_COMMAND  :IN,REAL  :IN )
;ENDFOLD (EXTERNAL DECLARATIONS)
DECL E6POS XP1={X 1500.5,Y -20.0,Z 900.0,A -180.0,B 0.0,C 180.0,S 2,T 35,E1 0.0,E2 0.0}
DECL FDAT FP1={TOOL_NO 1,BASE_NO 2,IPO_FRAME #BASE,POINT2[] " ",TQ_STATE FALSE}
DECL LDAT LCPDAT1={VEL 2.0,ACC 100.0,APO_DIST 50.0}
DECL INT PARTS=0
ENDDAT
)krl";

constexpr const char* kWeldProgram = R"krl(&ACCESS RVP
&REL 3
&PARAM TEMPLATE = C:\KRC\Roboter\Template\vorgabe
DEF  WELD ( )
;FOLD INI;%{PE}
  ;FOLD BASISTECH INI
    GLOBAL INTERRUPT DECL 3 WHEN $STOPMESS==TRUE DO IR_STOPM ( )
    INTERRUPT ON 3
    BAS (#INITMOV,0 )
  ;ENDFOLD (BASISTECH INI)
;ENDFOLD (INI)

;FOLD PTP HOME  Vel= 100 % DEFAULT;%{PE}%MKUKATPBASIS,%CMOVE,%VPTP
$BWDSTART = FALSE
PDAT_ACT=PDEFAULT
FDAT_ACT=FHOME
BAS (#PTP_PARAMS,100 )
$H_POS=XHOME
PTP  XHOME
;ENDFOLD
LOOP
  ;FOLD LIN P1 CONT Vel=2 m/s CPDAT1 Tool[1] Base[2];%{PE}
  $BWDSTART=FALSE
  LDAT_ACT=LCPDAT1
  FDAT_ACT=FP1
  BAS(#CP_PARAMS,2)
  LIN XP1 C_DIS C_DIS
  ;ENDFOLD
  LIN XP1 : {X 0, Y 0, Z -100, A 0, B 0, C 0}
  $OUT[5]=TRUE
  WAIT FOR ( $IN[7] )
  PARTS = PARTS + 1
  IF (PARTS >= 3) THEN
    EXIT
  ENDIF
ENDLOOP
PTP  XHOME
END
)krl";

TEST(ProductionPrograms, OfInlineFormsRun) {
  Bench bench(std::vector<Source>{
      {"$config.dat", kWeldConfiguration}, {"weld.dat", kWeldData}, {"weld.src", kWeldProgram}});
  std::vector<std::string> bas;
  bench.host.set("$STOPMESS", false);
  bench.host.set("$IN[7]", true);
  bench.host.on_call = [&](ExternalCall& call) {
    bas.push_back(std::get<Literal>(call.arguments[0]).name + " " +
                  std::to_string(static_cast<int>(number_of(call.arguments[1]))));
    return CallResult{};
  };
  const Interpreter& weld = bench.start("WELD");
  bench.run_until_quiet();
  EXPECT_EQ(weld.state(), ProgramState::Ended) << (weld.fault() ? weld.fault()->text() : "");
  EXPECT_EQ(bench.integer("PARTS"), 3);
  EXPECT_EQ(bas, (std::vector<std::string>{"INITMOV 0", "PTP_PARAMS 100", "CP_PARAMS 2", "CP_PARAMS 2",
                                           "CP_PARAMS 2"}));
  ASSERT_EQ(bench.host.moved.size(), 8u);
  const PoseTarget& point = std::get<PoseTarget>(bench.host.moved[1].target);
  EXPECT_EQ(point.pose[0], 1500.5);
  EXPECT_EQ(point.status, 2);
  EXPECT_EQ(point.turn, 35);
  // B = 0 and C = 180: the tool looks down, and 100 mm against its direction lead up.
  const PoseTarget& above = std::get<PoseTarget>(bench.host.moved[2].target);
  EXPECT_NEAR(*above.pose[2], 1000, 1e-3);
}

}  // namespace
}  // namespace truepose::sim::krl
