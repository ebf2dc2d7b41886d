#include <gtest/gtest.h>

#include "proto/rsi/cell_word.hpp"
#include "tests/tools/sim/krl/listening_cell.hpp"

namespace truepose::sim::krl {
namespace {

TEST(StateServer, AnswersEachControlWithTheState) {
  ScriptedCell cell;
  Interpreter& submit = cell.bench.start("SPS", InterpreterKind::Submit);
  cell.connect();
  cell.control(8, 5);
  cell.bench.run_for(12ms);
  ASSERT_EQ(cell.states, 1) << (submit.fault() ? submit.fault()->text() : "");
  EXPECT_EQ(std::get<std::int32_t>(cell.state["CellState/Robot/State/@Id"]), 8);
  EXPECT_EQ(std::get<std::int32_t>(cell.state["CellState/Robot/State/@ModeOp"]), 4);
  EXPECT_EQ(std::get<std::int32_t>(cell.state["CellState/Robot/State/@ProState"]), 3);
  EXPECT_EQ(std::get<std::int32_t>(cell.state["CellState/Robot/State/@InPos"]), 1);
  EXPECT_EQ(std::get<double>(cell.state["CellState/Robot/State/Pos/@B"]), 90);
}

TEST(StateServer, TellsByRsiOfStopGateAndToolAsLongAsItRuns) {
  ScriptedCell cell;
  cell.bench.start("SPS", InterpreterKind::Submit);
  const auto signals = [&] {
    cell.bench.run_for(40ms);
    return rsi::cell_signals(std::get<std::int32_t>(cell.bench.host.variables["$SEN_PINT[3]"]));
  };
  const auto first = signals();
  ASSERT_TRUE(first) << "nobody is connected";
  cell.bench.host.set("$ACT_TOOL", 3);
  cell.bench.host.set("$ALARM_STOP", false);
  const auto pressed = signals();
  EXPECT_EQ(pressed, (rsi::CellSignals{true, false, 3, pressed->count}));
  EXPECT_GT(pressed->count, first->count);
  cell.bench.host.set("$ALARM_STOP", true);
  cell.bench.host.set("$USER_SAF", false);
  cell.bench.host.variables.erase("$ACT_TOOL");
  const auto open = signals();
  EXPECT_EQ(open, (rsi::CellSignals{false, true, {}, open->count}));
  int last = open->count;
  for (int cycle = 0; cycle < 1000; ++cycle) {
    const auto now = signals();
    ASSERT_TRUE(now) << "after " << last;
    last = now->count;
  }
  EXPECT_LE(last, 1000);
  cell.bench.host.set("$ACT_TOOL", 256);
  EXPECT_FALSE(signals()) << "the word has no room for it";
}

TEST(StateServer, BoundsTheOverride) {
  ScriptedCell cell;
  cell.bench.start("SPS", InterpreterKind::Submit);
  cell.connect();
  cell.control(1, 1, 51);
  cell.bench.run_for(20ms);
  EXPECT_EQ(std::get<std::int32_t>(cell.bench.host.variables["$OV_PRO"]), 100);
  cell.control(2, 1, 50);
  cell.bench.run_for(20ms);
  EXPECT_EQ(std::get<std::int32_t>(cell.bench.host.variables["$OV_PRO"]), 50);
}

TEST(StateServer, StopsTheMotionProgram) {
  Listening cell(InterpreterKind::Submit);
  cell.command(1, 1, 30);
  cell.take_said();
  cell.control(1, 2);
  cell.bench.run_for(200ms);
  EXPECT_EQ(cell.take_said(), Said{"Ack 1 5 3"}) << cell.fault();
  EXPECT_EQ(cell.states, 1);
}

TEST(StateServer, TellsWhichArmItIs) {
  ScriptedCell cell;
  cell.bench.start("SPS", InterpreterKind::Submit);
  cell.connect();
  cell.control(1, 5);
  cell.bench.run_for(20ms);
  ASSERT_EQ(cell.states, 1);
  EXPECT_EQ(std::get<std::int32_t>(cell.state["CellState/Robot/State/@Serial"]), 4711);
}

TEST(StateServer, SendsTheFramesInForceAndWhileTpBeginWorksInTheFlangeThoseOfTheProgram) {
  ScriptedCell cell{shipped_sources(program_of(
      "$TOOL={X 10,Y 0,Z 250,A 90,B 0,C 0}\n$BASE={X 900,Y 0,Z 500,A 0,B 0,C 0}\nWAIT FOR $IN[1]\nTP_BEGIN()"))};
  cell.bench.start("SPS", InterpreterKind::Submit);
  cell.bench.start("P");
  cell.connect();
  const auto sent = [&](const std::string& path) {
    return std::get<double>(cell.state["CellState/Robot/State/" + path]);
  };
  cell.control(1, 5);
  cell.bench.run_for(20ms);
  ASSERT_EQ(cell.states, 1);
  EXPECT_EQ(sent("ToolFrame/@Z"), 250);
  EXPECT_EQ(sent("ToolFrame/@A"), 90);
  EXPECT_EQ(sent("BaseFrame/@X"), 900);
  EXPECT_EQ(sent("Load/@M"), -1) << "there is none";
  cell.bench.host.set("$IN[1]", true);
  cell.bench.run_for(2s);
  EXPECT_EQ(cell.said.back(), "RSI_ON");
  cell.control(2, 5);
  cell.bench.run_for(20ms);
  ASSERT_EQ(cell.states, 2);
  EXPECT_EQ(sent("ToolFrame/@Z"), 250) << "not the flange's";
  EXPECT_EQ(sent("BaseFrame/@X"), 900);
}

TEST(StateServer, IsNotMisledByATpBeginThatWasCancelled) {
  ScriptedCell cell{shipped_sources(program_of(
      "TP_BEGINS=TRUE\n$TOOL={X 10,Y 0,Z 250,A 90,B 0,C 0}\n$BASE={X 900,Y 0,Z 500,A 0,B 0,C 0}\nWAIT FOR $IN[1]"))};
  cell.bench.start("SPS", InterpreterKind::Submit);
  cell.bench.start("P");
  cell.connect();
  cell.control(1, 5);
  cell.bench.run_for(20ms);
  ASSERT_EQ(cell.states, 1);
  EXPECT_EQ(std::get<double>(cell.state["CellState/Robot/State/ToolFrame/@Z"]), 250);
  EXPECT_EQ(std::get<double>(cell.state["CellState/Robot/State/BaseFrame/@X"]), 900);
}

TEST(StateServer, TellsTheStateWhereNoPositionHasAValue) {
  ScriptedCell cell;
  Interpreter& submit = cell.bench.start("SPS", InterpreterKind::Submit);
  cell.connect();
  for (const char* name : {"$POS_ACT_MES", "$ACT_TOOL", "$ACT_BASE"}) cell.bench.host.variables.erase(name);
  cell.control(1, 5);
  cell.bench.run_for(20ms);
  EXPECT_FALSE(submit.fault()) << submit.fault()->text();
  ASSERT_EQ(cell.states, 1);
  EXPECT_EQ(std::get<double>(cell.state["CellState/Robot/State/Pos/@X"]), 0);
  EXPECT_EQ(std::get<std::int32_t>(cell.state["CellState/Robot/State/Tool/@No"]), -1);
}

TEST(StateServer, SaysOnThePendantThatItsChannelCannotBeUsedAndTriesAgain) {
  ScriptedCell cell;
  cell.init_fails = true;
  cell.bench.start("SPS", InterpreterKind::Submit);
  ASSERT_EQ(cell.bench.host.messages.size(), 1u);
  EXPECT_EQ(cell.bench.host.messages[0], "EKI_Init of CellState failed: is CellState.xml in EthernetKRL?");
  cell.bench.run_for(11s);
  cell.connect();
  cell.control(1, 5);
  cell.bench.run_for(20ms);
  EXPECT_EQ(cell.states, 1);
}

/// The sps.sub of a controller without a further submit interpreter: the customer's own work around ours.
struct OneSubmit : ScriptedCell {
  OneSubmit()
      : ScriptedCell{shipped_sources({{"sps.sub", R"krl(
DEF SPS()
   SCANS=0
;FOLD USER INIT
   TP_SUBMIT_INIT()
;ENDFOLD (USER INIT)
   LOOP
      WAIT FOR NOT($POWER_FAIL)
;FOLD USER PLC
      TP_SUBMIT_CYCLE()
      $OUT[1]=$IN[1] AND NOT $IN[2]
      SCANS=SCANS+1
      IF $IN[3] THEN
         WAIT SEC 0.012
      ENDIF
;ENDFOLD (USER PLC)
   ENDLOOP
END
)krl"},
                                      {"sps.dat", "DEFDAT SPS PUBLIC\nDECL INT SCANS=0\nENDDAT\n"}})} {
    bench.host.set("$POWER_FAIL", false);
    sps = &bench.start("SPS", InterpreterKind::Submit);
  }
  /// Whether the customer's loop runs as fast as it can.
  bool scans() {
    const int before = bench.integer("SCANS");
    bench.run_for(100ms);
    return bench.integer("SCANS") > before + 1000;
  }
  /// Lets time pass in which the customer's own work takes 12 ms a scan.
  void pass(Time time) {
    bench.host.set("$IN[3]", true);
    bench.run_for(time);
    bench.host.set("$IN[3]", false);
  }
  int answers(int id) {
    const int before = states;
    control(id, 5);
    bench.run_for(20ms);
    return states - before;
  }
  std::string fault() const { return sps->fault() ? sps->fault()->text() : ""; }
  Interpreter* sps = nullptr;
};

TEST(StateServerInSps, AnswersAndNeverHoldsUpTheCustomersLoop) {
  OneSubmit cell;
  EXPECT_TRUE(cell.scans()) << "without a client: " << cell.fault();
  cell.connect();
  EXPECT_TRUE(cell.scans()) << "with one that is silent: " << cell.fault();
  EXPECT_EQ(cell.answers(1), 1) << cell.fault();
  for (int id = 2; id <= 9; ++id) cell.control(id, 5);
  cell.bench.run_for(20ms);
  EXPECT_EQ(cell.states, 9);
  EXPECT_EQ(std::get<std::int32_t>(cell.state["CellState/Robot/State/@Id"]), 9);
  cell.bench.host.set("$IN[1]", true);
  EXPECT_TRUE(cell.scans());
  EXPECT_EQ(cell.bench.host.variables["$OUT[1]"], Value{true});
}

TEST(StateServerInSps, TakesTheNextClientWheneverOneIsGone) {
  OneSubmit cell;
  for (int id = 1; id <= 5; ++id) {
    cell.connect();
    EXPECT_EQ(cell.answers(id), 1) << cell.fault();
    cell.disconnect();
    EXPECT_TRUE(cell.scans());
  }
  cell.connect_and_disconnect_unseen();
  cell.connect();
  EXPECT_EQ(cell.answers(6), 0) << "the channel waits to be reopened";
  cell.pass(11s);
  cell.connect();
  EXPECT_EQ(cell.answers(7), 1) << cell.fault();
}

TEST(StateServerInSps, ScansOnWhereItsChannelCannotBeUsedAndSaysSoOnce) {
  OneSubmit cell;
  cell.disconnect();
  cell.init_fails = true;
  cell.pass(11s);
  EXPECT_TRUE(cell.scans()) << cell.fault();
  EXPECT_EQ(cell.bench.host.messages, Said{"EKI_Init of CellState failed: is CellState.xml in EthernetKRL?"});
  cell.pass(11s);
  cell.connect();
  EXPECT_EQ(cell.answers(1), 1) << cell.fault();
}

}  // namespace
}  // namespace truepose::sim::krl
