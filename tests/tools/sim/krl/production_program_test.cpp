#include <gtest/gtest.h>

#include <algorithm>

#include "proto/rsi/gain_word.hpp"
#include "tests/tools/sim/krl/listening_cell.hpp"

namespace truepose::sim::krl {
namespace {

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
  void tell_gain(int percent) {
    bench.host.rewritten["$SEN_PINT[2]"] = [percent](Time now) {
      const auto ipoc = static_cast<std::uint64_t>(now / 4ms * 4);
      return Value{static_cast<std::int32_t>(rsi::gain_word(percent, ipoc))};
    };
  }
  void end_rsi() {
    bench.host.set("$SEN_PINT[2]", bench.host.rewritten["$SEN_PINT[2]"](bench.host.now));
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

/// No manual says that what TP_BEGIN and TP_END use stops the advance run: with it three motions ahead they
/// must wait for the arm all the same.
TEST(ProductionProgram, BeginsAndEndsWhereTheArmIsWhateverPassesTheAdvanceRun) {
  ScriptedCell cell{shipped_sources(program_of(
                        "$TOOL={X 0,Y 0,Z 0,A 0,B 0,C 0}\n$BASE={X 0,Y 0,Z 0,A 0,B 0,C 0}\n"
                        "PTP {A1 1}\nPTP {A1 2}\nTP_BEGIN()\nPTP {A1 3}\nPTP {A1 4}\nPTP {A1 5}\nTP_END()")),
                    {"$SEN_PINT", "$AXIS_ACT_MEAS", "RSI_RESET", "RSI_CREATE", "RSI_ON", "RSI_OFF",
                     "RSI_DELETE", "MSGNOTIFY"}};
  FakeHost& host = cell.bench.host;
  int gain = 0;
  host.rewritten["$SEN_PINT[2]"] = [&](Time now) {
    const bool asks = host.variables["$SEN_PINT[1]"] == Value{1};
    if (!asks && gain == 100) host.log.push_back("asked to ramp out");
    gain = asks ? 100 : 0;
    return Value{static_cast<std::int32_t>(rsi::gain_word(gain, static_cast<std::uint64_t>(now / 1ms)))};
  };
  cell.on_send = [&](const std::string& what) { host.log.push_back(what); };
  Interpreter& program = cell.bench.start("P");
  cell.bench.run_for(60s);
  EXPECT_EQ(program.state(), ProgramState::Ended) << (program.fault() ? program.fault()->text() : "");
  const auto at = [&](const std::string& entry) {
    return std::ranges::find(host.log, entry) - host.log.begin();
  };
  EXPECT_LT(at("2 is made"), at("RSI_RESET"));
  EXPECT_LT(at("2 is made"), at("move 3")) << "which goes to where the arm stands";
  EXPECT_LT(at("6 is made"), at("asked to ramp out"));
  EXPECT_LT(at("asked to ramp out"), at("RSI_OFF"));
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

TEST(ProductionProgram, ReopensRsiWhereItTimedOutBeforeTheCorrectionWasInEffect) {
  Production cell;
  cell.bench.run_for(2s);
  cell.tell_gain(40);
  cell.bench.run_for(500ms);
  cell.end_rsi();
  cell.bench.run_for(2s);
  EXPECT_EQ(cell.program->state(), ProgramState::Stopped);
  EXPECT_EQ(cell.bench.host.messages, Said{"RSI has ended: start the program again to reopen it"});
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
