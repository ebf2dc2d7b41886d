#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "tests/tools/sim/krl/scripted_eki.hpp"

namespace truepose::sim::krl {
namespace {

using Said = std::vector<std::string>;

/// The motion program, past its first motion, greeted and listening.
struct Listening : ScriptedCell {
  explicit Listening(InterpreterKind with = InterpreterKind::Robot) : ScriptedCell{mended_sources()} {
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

TEST(ShippedPrograms, HaveAParameterThatTheControllerRefuses) {
  EXPECT_EQ(load_error(shipped_sources(), cell_declarations()),
            "truepose_motion.src:248: AXIS is the name of a type and cannot be another name");
  EXPECT_EQ(load_error(mended_sources(), cell_declarations()), "") << "and nothing else";
}

TEST(MotionProgram, MovesWhereTheArmStandsAndGreets) {
  ScriptedCell cell(mended_sources());
  Interpreter& motion = cell.bench.start("TRUEPOSE_MOTION");
  ASSERT_EQ(cell.bench.host.moved.size(), 1u);
  EXPECT_EQ(std::get<AxisTarget>(cell.bench.host.moved[0].target).axes[0], 0);
  cell.bench.run_for(5s);
  EXPECT_EQ(cell.greetings, 0);
  cell.connect();
  ASSERT_EQ(cell.said.size(), 1u);
  EXPECT_EQ(cell.said[0].substr(0, 22), "Hello #KR210R2700 4711");
  EXPECT_EQ(cell.said[0].size(), 18u + 32u) << "the serial number goes out with its blanks";
  EXPECT_EQ(motion.state(), ProgramState::Active);
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
  cell.bench.run_for(0s);
  EXPECT_EQ(cell.take_said(), (Said{"RSI_OFF", "RSI_DELETE", "Ack 1 3 0"}));
}

TEST(MotionProgram, ClosesRsiAtAStop) {
  Listening cell;
  cell.command(1, 3);
  cell.take_said();
  cell.bench.host.set("$FLAG[103]", true);
  cell.bench.run_for(200ms);
  EXPECT_EQ(cell.take_said(), (Said{"RSI_OFF", "RSI_DELETE", "Ack 1 5 3"})) << cell.fault();
}

TEST(MotionProgram, TellsThatRsiDidNotOpen) {
  Listening cell;
  cell.rsi_create_result = 1;
  cell.command(1, 3);
  EXPECT_EQ(cell.take_said(), (Said{"RSI_CREATE", "Ack 1 4 6"}));
}

TEST(MotionProgram, CanBeResetInAMotionAndStartedAgain) {
  Listening cell;
  cell.command(1, 1, 30);
  cell.bench.run_for(300ms);
  cell.motion->reset();
  EXPECT_TRUE(cell.motion->start());
  cell.bench.run_for(2s);
  cell.take_said();
  cell.command(1, 1, 30);
  EXPECT_EQ(cell.take_said(), Said{"Ack 1 2 0"}) << "its last answer; module data stays";
  cell.command(2, 9);
  EXPECT_EQ(cell.take_said(), Said{"Ack 2 3 0"}) << cell.fault();
}

TEST(StateServer, AnswersEachControlWithTheState) {
  ScriptedCell cell(mended_sources());
  Interpreter& submit = cell.bench.start("TRUEPOSE_SUBMIT", InterpreterKind::Submit);
  cell.connect();
  cell.control(8, 5);
  cell.bench.run_for(12ms);
  ASSERT_EQ(cell.states, 1) << (submit.fault() ? submit.fault()->text() : "");
  EXPECT_EQ(std::get<std::int32_t>(cell.state["CellState/State/@Id"]), 8);
  EXPECT_EQ(std::get<std::int32_t>(cell.state["CellState/State/@ModeOp"]), 4);
  EXPECT_EQ(std::get<std::int32_t>(cell.state["CellState/State/@ProState"]), 3);
  EXPECT_EQ(std::get<std::int32_t>(cell.state["CellState/State/@InPos"]), 1);
  EXPECT_EQ(std::get<double>(cell.state["CellState/State/Pos/@B"]), 90);
}

TEST(StateServer, BoundsTheOverride) {
  ScriptedCell cell(mended_sources());
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

// The finding of the review that matters most: where no tool is in force the position has no value, and
// reading it ends the program that should tell the state.
TEST(StateServer, DiesWhereThePositionHasNoValue) {
  ScriptedCell cell(mended_sources());
  Interpreter& submit = cell.bench.start("TRUEPOSE_SUBMIT", InterpreterKind::Submit);
  cell.connect();
  cell.bench.host.variables.erase("$POS_ACT_MES");
  cell.control(1, 5);
  cell.bench.run_for(20ms);
  ASSERT_TRUE(submit.fault());
  EXPECT_EQ(submit.fault()->text(), "truepose_submit.sub:69: the variable $POS_ACT_MES has no value");
}

}  // namespace
}  // namespace truepose::sim::krl
