#include <gtest/gtest.h>

#include "tests/tools/sim/krl/listening_cell.hpp"

namespace truepose::sim::krl {
namespace {

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

}  // namespace
}  // namespace truepose::sim::krl
