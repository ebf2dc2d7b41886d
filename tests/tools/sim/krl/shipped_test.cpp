#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "proto/rsi/cell_word.hpp"
#include "tests/tools/sim/krl/scripted_eki.hpp"

namespace truepose::sim::krl {
namespace {

using Said = std::vector<std::string>;

/// The motion program, past its first motion, greeted and listening.
struct Listening : ScriptedCell {
  explicit Listening(InterpreterKind with = InterpreterKind::Robot) {
    if (with == InterpreterKind::Submit) bench.start("TRUEPOSE_SUBMIT", InterpreterKind::Submit);
    motion = &bench.start("TRUEPOSE_MOTION");
    bench.run_for(1s);
    connect();
    said.clear();
    bench.host.log.clear();
  }

  std::string fault() const { return motion->fault() ? motion->fault()->text() : ""; }
  Said take_said() { return std::exchange(said, {}); }

  Interpreter* motion = nullptr;
};

TEST(ShippedPrograms, AreWhatAControllerLoads) { EXPECT_EQ(load_error(shipped_sources()), ""); }

TEST(MotionProgram, MovesWhereTheArmStandsAndGreets) {
  ScriptedCell cell;
  Interpreter& motion = cell.bench.start("TRUEPOSE_MOTION");
  ASSERT_EQ(cell.bench.host.moved.size(), 1u);
  EXPECT_EQ(std::get<AxisTarget>(cell.bench.host.moved[0].target).axes[0], 0);
  cell.bench.run_for(5s);
  EXPECT_EQ(cell.greetings, 0);
  cell.connect();
  EXPECT_EQ(cell.said, (Said{"RSI_RESET", "Hello #KR210R2700 4711"}));
  EXPECT_EQ(motion.state(), ProgramState::Active);
}

TEST(MotionProgram, GreetsTheNextClientWhereOneCameAndWentUnseen) {
  ScriptedCell cell;
  cell.bench.start("TRUEPOSE_MOTION");
  cell.bench.run_for(2s);
  cell.connect_and_disconnect_unseen();
  cell.connect();
  EXPECT_EQ(cell.greetings, 0);
  cell.bench.run_for(10s);
  cell.connect();
  EXPECT_EQ(cell.greetings, 1);
}

TEST(MotionProgram, AcceptsMovesArrivesAndSettles) {
  Listening cell;
  cell.command(1, 1, 30);
  EXPECT_EQ(cell.take_said(), (Said{"Ack 1 1 0", "Ack 1 2 0"})) << cell.fault();
  ASSERT_EQ(cell.bench.host.moved.size(), 2u);
  const Motion& motion = cell.bench.host.moved[1];
  EXPECT_EQ(motion.kind, MotionKind::Ptp);
  EXPECT_EQ(std::get<AxisTarget>(motion.target).axes[0], 30);
  EXPECT_EQ(motion.velocity_percent, (std::array<int, 6>{50, 50, 50, 50, 50, 50}));
  EXPECT_EQ(motion.acceleration_percent[5], 100) << "200 was asked";
  cell.bench.run_for(1s + 499ms);
  EXPECT_EQ(cell.take_said(), Said{});
  cell.bench.run_for(1ms);
  EXPECT_EQ(cell.take_said(), Said{"Ack 1 3 0"});
}

TEST(MotionProgram, CarriesOutCommandsInTurnAndARepeatedOneOnce) {
  Listening cell;
  cell.command(1, 9);
  cell.command(1, 9);
  cell.command(2, 9);
  EXPECT_EQ(cell.take_said(), (Said{"Ack 1 3 0", "Ack 1 3 0", "Ack 2 3 0"}));
}

TEST(MotionProgram, RefusesWhatLiesOutsideOfTheLimitsAndTypesItDoesNotKnow) {
  Listening cell;
  cell.command(1, 1, 186);
  cell.command(2, 7);
  EXPECT_EQ(cell.take_said(), (Said{"Ack 1 4 1", "Ack 2 4 2"}));
  EXPECT_EQ(cell.bench.host.moved.size(), 1u);
}

TEST(MotionProgram, TellsThatTheArmDidNotArrive) {
  Listening cell;
  cell.bench.host.on_arrival = nullptr;
  cell.command(1, 1, 30);
  cell.bench.run_for(2s);
  EXPECT_EQ(cell.said.back(), "Ack 1 5 4");
}

TEST(MotionProgram, BrakesAtAStopWhileItMoves) {
  Listening cell;
  cell.command(1, 1, 30);
  cell.bench.run_for(400ms);
  cell.take_said();
  cell.bench.host.set("$FLAG[103]", true);
  cell.bench.run_for(99ms);
  EXPECT_EQ(cell.take_said(), Said{});
  cell.bench.run_for(1ms);
  EXPECT_EQ(cell.take_said(), Said{"Ack 1 5 3"}) << cell.fault();
  EXPECT_EQ(cell.bench.host.log, (Said{"move 2", "brake", "cancel"}));
  cell.command(2, 1, 10);
  EXPECT_EQ(cell.take_said(), Said{"Ack 2 4 3"}) << "stopped still";
  cell.bench.host.set("$FLAG[103]", false);
  cell.command(3, 1, 10);
  cell.bench.run_for(2s);
  EXPECT_EQ(cell.take_said(), (Said{"Ack 3 1 0", "Ack 3 2 0", "Ack 3 3 0"}));
}

TEST(MotionProgram, BrakesAtAStopWhileItSettles) {
  Listening cell;
  cell.command(1, 1, 30);
  cell.bench.run_for(1200ms);
  cell.take_said();
  cell.bench.host.set("$FLAG[103]", true);
  cell.bench.run_for(200ms);
  EXPECT_EQ(cell.take_said(), Said{"Ack 1 5 3"}) << cell.fault();
}

TEST(MotionProgram, LeavesAStopMessageToTheControllersOwnProgram) {
  Listening cell;
  cell.command(1, 1, 30);
  cell.take_said();
  cell.bench.host.set("$STOPMESS", true);
  cell.bench.run_for(100ms);
  EXPECT_EQ(cell.take_said(), Said{"IR_STOPM"}) << cell.fault();
  cell.bench.run_for(2s);
  EXPECT_EQ(cell.take_said(), Said{"Ack 1 3 0"}) << "and goes on";
}

TEST(MotionProgram, IgnoresAStopWhileItWaitsForACommand) {
  Listening cell;
  cell.bench.host.set("$FLAG[103]", true);
  cell.bench.run_for(1s);
  EXPECT_EQ(cell.take_said(), Said{});
  EXPECT_EQ(cell.motion->state(), ProgramState::Active);
}

TEST(MotionProgram, BrakesWhereTheLinkIsLostAndGreetsAgain) {
  Listening cell;
  cell.command(1, 1, 30);
  cell.bench.run_for(400ms);
  cell.take_said();
  cell.disconnect();
  cell.bench.run_for(1s);
  EXPECT_EQ(cell.bench.host.log, (Said{"move 2", "brake", "cancel"}));
  EXPECT_EQ(cell.take_said(), Said{}) << "nobody is there";
  cell.connect();
  EXPECT_EQ(cell.greetings, 2);
  cell.take_said();
  cell.command(1, 1, 30);
  EXPECT_EQ(cell.take_said(), Said{"Ack 1 5 5"}) << "the answer that was lost";
}

TEST(MotionProgram, StreamsUntilThePcLeaves) {
  Listening cell;
  cell.command(1, 3);
  cell.bench.run_for(10s);
  EXPECT_EQ(cell.take_said(), (Said{"RSI_CREATE", "RSI_ON", "Ack 1 2 0", "RSI_MOVECORR"})) << cell.fault();
  cell.rsi_leaves = true;
  cell.bench.run_for(2s);
  EXPECT_EQ(cell.bench.host.moved.size(), 2u) << "to where the arm stands, before the context goes";
  EXPECT_EQ(cell.take_said(), (Said{"RSI_OFF", "RSI_DELETE", "Ack 1 3 0"}));
}

TEST(MotionProgram, ClosesRsiAtAStop) {
  Listening cell;
  cell.command(1, 3);
  cell.take_said();
  cell.bench.host.set("$FLAG[103]", true);
  cell.bench.run_for(2s);
  EXPECT_EQ(cell.take_said(), (Said{"RSI_OFF", "RSI_DELETE", "Ack 1 5 3"})) << cell.fault();
}

TEST(MotionProgram, TellsThatRsiDidNotOpen) {
  Listening cell;
  cell.rsi_create_result = 1;
  cell.command(1, 3);
  EXPECT_EQ(cell.take_said(), (Said{"RSI_CREATE", "Ack 1 4 6"}));
}

TEST(MotionProgram, RefusesWhatWaitedBehindACommandThatAStopBrokeOff) {
  Listening cell;
  cell.command(1, 1, 30);
  cell.bench.run_for(400ms);
  cell.command(2, 1, -30);
  cell.bench.host.set("$FLAG[102]", false);  // as where both came before the first was read
  cell.take_said();
  cell.bench.host.set("$FLAG[103]", true);
  cell.bench.run_for(200ms);
  EXPECT_EQ(cell.take_said(), (Said{"Ack 1 5 3", "Ack 2 4 3"})) << cell.fault();
  cell.bench.host.set("$FLAG[103]", false);
  cell.bench.run_for(5s);
  cell.command(3, 9);
  EXPECT_EQ(cell.take_said(), Said{"Ack 3 3 0"});
  EXPECT_EQ(cell.bench.host.moved.size(), 2u) << "the old target is not driven to";
}

TEST(MotionProgram, SaysOneLastWordOnACommandThoughAStopComesWithIt) {
  Listening cell;
  cell.on_send = [&](const std::string& said) {
    if (said == "Ack 1 3 0" || said == "Ack 2 4 2") cell.bench.host.set("$FLAG[103]", true);
  };
  cell.command(1, 9);
  cell.bench.run_for(200ms);
  EXPECT_EQ(cell.take_said(), Said{"Ack 1 3 0"});
  cell.bench.host.set("$FLAG[103]", false);
  cell.command(2, 7);
  cell.bench.run_for(200ms);
  EXPECT_EQ(cell.take_said(), Said{"Ack 2 4 2"}) << cell.fault();
}

TEST(MotionProgram, DeletesTheContextThatAStopFindsJustCreated) {
  Listening cell;
  cell.on_send = [&](const std::string& said) {
    if (said == "RSI_CREATE") cell.bench.host.set("$FLAG[103]", true);
  };
  cell.command(1, 3);
  cell.bench.run_for(2s);
  EXPECT_EQ(cell.take_said(), (Said{"RSI_CREATE", "RSI_OFF", "RSI_DELETE", "Ack 1 5 3"})) << cell.fault();
}

TEST(MotionProgram, CanBeResetInAMotionAndStartedAgain) {
  Listening cell;
  cell.command(1, 1, 30);
  cell.bench.run_for(300ms);
  cell.motion->reset();
  EXPECT_TRUE(cell.motion->start());
  cell.bench.run_for(2s);
  cell.connect();
  cell.take_said();
  cell.command(1, 1, 30);
  EXPECT_EQ(cell.take_said(), Said{"Ack 1 2 0"}) << "its last answer; module data stays";
  cell.command(2, 9);
  EXPECT_EQ(cell.take_said(), Said{"Ack 2 3 0"}) << cell.fault();
}

TEST(StateServer, AnswersEachControlWithTheState) {
  ScriptedCell cell;
  Interpreter& submit = cell.bench.start("TRUEPOSE_SUBMIT", InterpreterKind::Submit);
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
  cell.bench.start("TRUEPOSE_SUBMIT", InterpreterKind::Submit);
  const auto told = [&] {
    cell.bench.run_for(40ms);
    return rsi::cell_signals(std::get<std::int32_t>(cell.bench.host.variables["$SEN_PINT[3]"]));
  };
  const auto first = told();
  ASSERT_TRUE(first) << "nobody is connected";
  cell.bench.host.set("$ACT_TOOL", 3);
  cell.bench.host.set("$ALARM_STOP", false);
  const auto pressed = told();
  EXPECT_EQ(pressed, (rsi::CellSignals{true, false, 3, pressed->count}));
  EXPECT_GT(pressed->count, first->count);
  cell.bench.host.set("$ALARM_STOP", true);
  cell.bench.host.set("$USER_SAF", false);
  cell.bench.host.variables.erase("$ACT_TOOL");
  const auto open = told();
  EXPECT_EQ(open, (rsi::CellSignals{false, true, {}, open->count}));
  int last = open->count;
  for (int cycle = 0; cycle < 1000; ++cycle) {
    const auto now = told();
    ASSERT_TRUE(now) << "after " << last;
    last = now->count;
  }
  EXPECT_LE(last, 1000);
  cell.bench.host.set("$ACT_TOOL", 256);
  EXPECT_FALSE(told()) << "the word has no room for it";
}

TEST(StateServer, BoundsTheOverride) {
  ScriptedCell cell;
  cell.bench.start("TRUEPOSE_SUBMIT", InterpreterKind::Submit);
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
  cell.bench.start("TRUEPOSE_SUBMIT", InterpreterKind::Submit);
  cell.connect();
  cell.control(1, 5);
  cell.bench.run_for(20ms);
  ASSERT_EQ(cell.states, 1);
  EXPECT_EQ(std::get<std::int32_t>(cell.state["CellState/Robot/State/@Serial"]), 4711);
}

TEST(StateServer, TellsTheStateWhereNoPositionHasAValue) {
  ScriptedCell cell;
  Interpreter& submit = cell.bench.start("TRUEPOSE_SUBMIT", InterpreterKind::Submit);
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
  cell.bench.start("TRUEPOSE_SUBMIT", InterpreterKind::Submit);
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
  EXPECT_EQ(cell.answers(6), 0) << "the channel waits to be opened anew";
  cell.bench.run_for(11s);
  cell.connect();
  EXPECT_EQ(cell.answers(7), 1) << cell.fault();
}

TEST(StateServerInSps, ScansOnWhereItsChannelCannotBeUsedAndSaysSoNowAndThen) {
  OneSubmit cell;
  cell.disconnect();
  cell.init_fails = true;
  cell.bench.run_for(11s);
  EXPECT_EQ(cell.bench.host.messages, Said{"EKI_Init of CellState failed: is CellState.xml in EthernetKRL?"});
  EXPECT_TRUE(cell.scans()) << cell.fault();
  cell.bench.run_for(11s);
  cell.connect();
  EXPECT_EQ(cell.answers(1), 1) << cell.fault();
}

/// A production program of a customer between TP_BEGIN and TP_END, and the PC as $SEN_PINT shows it.
struct Production : ScriptedCell {
  Production()
      : ScriptedCell{shipped_sources(
            program_of("$TOOL={X 0,Y 0,Z 250,A 0,B 0,C 0}\n$BASE={X 900,Y 0,Z 500,A 0,B 0,C 0}\nTP_BEGIN()\n"
                       "PTP {A1 10,A2 0,A3 0,A4 0,A5 0,A6 0}\nDONE=TP_OK()\nTP_END()",
                       "DECL GLOBAL BOOL DONE=FALSE"))} {
    on_send = [this](const std::string& what) {
      if (what == "RSI_ON") tell_gain(0);
    };
    program = &bench.start("P");
  }
  int asked() { return std::get<std::int32_t>(bench.host.variables["$SEN_PINT[1]"]); }
  /// RSI writes it in every cycle, and leaves the last when it times out.
  void tell_gain(int percent) { bench.host.rewritten["$SEN_PINT[2]"] = percent; }
  void end_rsi() {
    bench.host.set("$SEN_PINT[2]", bench.host.rewritten["$SEN_PINT[2]"]);
    bench.host.rewritten.clear();
    rsi_on = false;
  }
  std::string fault() const { return program->fault() ? program->fault()->text() : ""; }
  Interpreter* program = nullptr;
};

TEST(ProductionProgram, WaitsUntilItIsCorrectedAndUntilItIsNoMore) {
  Production cell;
  cell.bench.run_for(2s);
  EXPECT_EQ(cell.said, (Said{"RSI_RESET", "RSI_CREATE", "RSI_ON"})) << cell.fault();
  EXPECT_EQ(cell.asked(), 1);
  ASSERT_EQ(cell.bench.host.moved.size(), 1u) << "where it stands, in the flange and the robot's base";
  EXPECT_EQ(cell.bench.host.moved[0].tool, FrameValues{});
  EXPECT_EQ(cell.bench.host.moved[0].base, FrameValues{});
  cell.tell_gain(99);
  cell.bench.run_for(10s);
  EXPECT_EQ(cell.bench.host.moved.size(), 1u);
  cell.tell_gain(100);
  cell.bench.run_for(500ms);
  ASSERT_EQ(cell.bench.host.moved.size(), 2u);
  EXPECT_EQ(cell.bench.host.moved[1].tool->at(2), 250) << "the program's own again";
  EXPECT_EQ(cell.bench.host.moved[1].base->at(0), 900);
  cell.bench.run_for(2s);
  EXPECT_EQ(cell.asked(), 0);
  EXPECT_EQ(cell.bench.variable("DONE"), Value{true});
  cell.tell_gain(1);
  cell.bench.run_for(10s);
  EXPECT_EQ(cell.said.size(), 3u) << "RSI stays open while a correction is in force";
  cell.tell_gain(0);
  cell.bench.run_for(2s);
  EXPECT_EQ(cell.said, (Said{"RSI_RESET", "RSI_CREATE", "RSI_ON", "RSI_OFF", "RSI_DELETE"})) << cell.fault();
  EXPECT_EQ(cell.program->state(), ProgramState::Ended) << cell.fault();
  EXPECT_TRUE(cell.bench.host.messages.empty());
}

TEST(ProductionProgram, SaysOnThePendantOnceWhyItIsNotCorrected) {
  Production cell;
  cell.bench.run_for(2s);
  EXPECT_TRUE(cell.bench.host.messages.empty());
  for (const int why : {-1, -2, -3}) {
    cell.tell_gain(why);
    cell.bench.run_for(10s);
  }
  EXPECT_EQ(cell.bench.host.messages, (Said{"Not corrected: the stream is not armed (truepose stream arm)",
                                            "Not corrected: no model is active (truepose model activate)",
                                            "Not corrected: the stream has a fault (truepose status)"}));
  EXPECT_EQ(cell.bench.host.moved.size(), 1u) << "nothing moves meanwhile";
  cell.tell_gain(100);
  cell.bench.run_for(2s);
  EXPECT_EQ(cell.bench.host.moved.size(), 2u);
}

TEST(ProductionProgram, TellsThatItIsNotCorrectedAnyMore) {
  Production cell;
  cell.bench.run_for(2s);
  cell.tell_gain(100);
  cell.bench.run_for(500ms);
  cell.tell_gain(-3);
  cell.bench.run_for(10s);
  EXPECT_EQ(cell.bench.variable("DONE"), Value{false});
  EXPECT_EQ(cell.said.back(), "RSI_DELETE") << "what a fault holds is never ramped out: the program ends";
}

TEST(ProductionProgram, IsNotTakenInByTheLastWordOfAnRsiThatTimedOut) {
  Production cell;
  cell.bench.run_for(2s);
  cell.tell_gain(100);
  cell.bench.run_for(500ms);
  cell.end_rsi();
  cell.bench.run_for(10s);
  EXPECT_EQ(cell.bench.variable("DONE"), Value{false});
  EXPECT_EQ(cell.program->state(), ProgramState::Ended) << "it does not wait for a PC that nobody hears";
  EXPECT_EQ(cell.bench.host.messages,
            Said{"RSI had ended before TP_END: the points since were not corrected"});
}

TEST(ProductionProgram, OpensRsiAnewWhereItTimedOutBeforeTheCorrectionWasInForce) {
  Production cell;
  cell.bench.run_for(2s);
  cell.tell_gain(40);
  cell.bench.run_for(500ms);
  cell.end_rsi();
  cell.bench.run_for(2s);
  EXPECT_EQ(cell.program->state(), ProgramState::Stopped);
  EXPECT_EQ(cell.bench.host.messages, Said{"RSI has ended: start the program again, and it is opened anew"});
  cell.program->start();
  cell.bench.run_for(2s);
  EXPECT_EQ(cell.said, (Said{"RSI_RESET", "RSI_CREATE", "RSI_ON", "RSI_RESET", "RSI_CREATE", "RSI_ON"}));
  cell.tell_gain(100);
  cell.bench.run_for(2s);
  EXPECT_EQ(cell.bench.host.moved.size(), 3u) << "twice where it stands, and on";
}

TEST(ProductionProgram, HaltsWithAMessageWhereRsiDoesNotOpenAndTriesAgainWhenItGoesOn) {
  Production cell;
  cell.rsi_create_result = 1;
  cell.bench.run_for(5s);
  EXPECT_EQ(cell.bench.host.messages,
            Said{"RSI_CREATE of truepose_rsi failed: are its files in SensorInterface?"});
  EXPECT_EQ(cell.program->state(), ProgramState::Stopped);
  cell.rsi_create_result = 0;
  cell.program->start();
  cell.bench.run_for(5s);
  EXPECT_EQ(cell.said.at(cell.said.size() - 1), "RSI_ON") << cell.fault();
}

}  // namespace
}  // namespace truepose::sim::krl
