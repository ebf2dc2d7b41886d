#include "core/arm/forward.hpp"
#include "daemon/cell/stream_service.hpp"
#include "tests/daemon/watched_stream.hpp"

namespace truepose::daemon {
namespace {

namespace asio = boost::asio;
namespace json = boost::json;
using testing::AllOf;
using testing::HasSubstr;
using namespace std::chrono_literals;

/// A cell that is armed, and a controller with programs that open RSI now and then.
struct AnArmedStream : AWatchedStream {
  Wait armed() {
    const Answer answer = co_await ask("stream.arm");
    EXPECT_TRUE(answer) << answer.error().message;
  }
  /// It is armed for an arm that does not move, whatever is sent.
  Wait frozen() {
    rig.stuck = rig.q;
    co_await armed();
    co_await pass(5s);
    co_await expect_state("armed", "holding");
  }
  /// A program ends, and after a while another opens RSI.
  Wait another_program() {
    sends = false;
    co_await pass(5s);
    rig.restart(rig.ipoc + 1000);
    sends = true;
    co_await pass(2s);
  }
  /// Another daemon over the same store and controller arms as before. @return the cell's state then
  std::string state_under_next_daemon() {
    DaemonCell next{{io.get_executor(), config, robot, tracker, clock, *rig.cycle, *store, store_thread,
                     compute_thread, events, recorder, recorder_thread, wall_clock}};
    EXPECT_TRUE(finish(next.load_active_model()));
    arm_as_before(next);
    return std::string{finish(next.call("cell.status", {}, kOperator))->at("state").as_string()};
  }
  void arm_as_before(DaemonCell& daemon) {
    bool done = false;
    asio::co_spawn(io, daemon.arm_as_before(), [&](std::exception_ptr failed) { done = !failed; });
    EXPECT_TRUE(clock.run(io, [&] { return done; }));
  }
  Wait expect_state(std::string_view cell_state, std::string_view stream_state) {
    const Answer now = co_await ask("cell.status");
    EXPECT_EQ(now->at("state").as_string(), cell_state);
    EXPECT_EQ(now->at_pointer("/stream/state").as_string(), stream_state)
        << control::json_text(now->at("stream"));
  }
};

TEST_F(AnArmedStream, CorrectsEveryProgramThatOpensRsiWithoutRobotOrTracker) {
  sends = false;
  play([this]() -> Wait {
    co_await armed();
    co_await pass(1min);
    Answer now = co_await ask("cell.status");
    EXPECT_EQ(now->at("state"), "armed");
    EXPECT_EQ(now->at_pointer("/robot/connected"), false);
    EXPECT_EQ(now->at_pointer("/stream/reason"), "armed; no program has RSI open");
    EXPECT_EQ(fault_of(*now), "");
    for (int program = 0; program < 3; ++program) {
      co_await another_program();
      co_await expect_state("armed", "correcting");
      EXPECT_GT(rig.largest_applied_deg(), 0);
    }
    sends = false;
    co_await pass(10s);
    now = co_await ask("cell.status");
    EXPECT_EQ(now->at("state"), "armed");
    EXPECT_EQ(fault_of(*now), "") << "a program that ends is no fault";
    EXPECT_THAT(now->at_pointer("/stream/reason").as_string().c_str(),
                HasSubstr("no program has RSI open, the last packet came 10."));
  });
}

TEST_F(AnArmedStream, ShowsTheStateOfTheRobotAndTellsItsChanges) {
  play([this]() -> Wait {
    co_await armed();
    co_await pass(2s);
    Answer now = co_await ask("stream.status");
    EXPECT_EQ(now->at_pointer("/robot/mode"), "AUT");
    EXPECT_EQ(now->at_pointer("/robot/emergency_stop"), false);
    EXPECT_EQ(now->at_pointer("/robot/unknown"), "");
    const std::size_t before = event_data(control::Topic::Stream).size();
    robot.press_emergency_stop(true);
    co_await pass(1500ms);
    now = co_await ask("cell.status");
    EXPECT_EQ(now->at_pointer("/stream/robot/emergency_stop"), true);
    EXPECT_EQ(now->at_pointer("/stream/reason"), "an emergency stop is pressed");
    EXPECT_EQ(now->at_pointer("/robot/ready"), false) << "nobody is connected to move it";
    EXPECT_GT(event_data(control::Topic::Stream).size(), before);
    rig.program.state = 4;
    co_await pass(100ms);
    now = co_await ask("stream.status");
    EXPECT_EQ(now->at_pointer("/robot/program"), "stopped") << "by RSI, at once";
    rig.program.mode = 1;
    co_await pass(100ms);
    now = co_await ask("stream.status");
    EXPECT_EQ(now->at_pointer("/robot/mode"), "T1") << "by RSI, at once";
    rig.program.override_percent = 30;
    co_await pass(100ms);
    now = co_await ask("stream.status");
    EXPECT_EQ(now->at_pointer("/robot/override_percent").to_number<double>(), 30) << "by RSI, at once";
    rig.program.mode = 0;
    co_await pass(100ms);
    now = co_await ask("stream.status");
    EXPECT_EQ(now->at_pointer("/robot/mode"), "AUT") << "where nothing is wired there, by the state server";
  });
}

TEST_F(AnArmedStream, SaysThatRsiAndTheStateServerNameAnotherModeAndShowsTheStateServers) {
  play([this]() -> Wait {
    co_await armed();
    co_await pass(2s);
    rig.program.mode = 3;  // AUT, as the state server says
    co_await pass(10s);
    EXPECT_EQ(fault_of(*co_await ask("cell.status")), "");
    rig.program.mode = 1;
    co_await pass(1s);
    Answer now = co_await ask("cell.status");
    EXPECT_EQ(fault_of(*now), "") << "the state server sees a change later";
    EXPECT_EQ(now->at_pointer("/stream/robot/mode"), "T1");
    co_await pass(6s);
    now = co_await ask("cell.status");
    EXPECT_THAT(fault_of(*now),
                HasSubstr("RSI says that the operating mode is T1, CellState that it is AUT"));
    EXPECT_EQ(now->at_pointer("/stream/robot/mode"), "AUT");
    rig.program.mode = 3;
    co_await pass(1s);
    EXPECT_EQ(fault_of(*co_await ask("cell.status")), "");
  });
}

TEST_F(AnArmedStream, KnowsAStopAndTheGateByRsiWhereNoStateServerAnswersAsLongAsTheSubmitProgramRuns) {
  play([this]() -> Wait {
    robot.leave(1h);
    rig.program = {.ask = 1, .state = 3, .mode = 4, .override_percent = 100, .cell = 1024};
    co_await armed();
    co_await pass(2s);
    Answer now = co_await ask("stream.status");
    EXPECT_TRUE(now->at_pointer("/robot/emergency_stop").is_null())
        << "of a submit program that does not count";
    EXPECT_EQ(now->at_pointer("/robot/unknown"), "the controller does not answer");
    counts = true;
    co_await pass(200ms);
    now = co_await ask("stream.status");
    EXPECT_EQ(now->at_pointer("/robot/emergency_stop"), false);
    EXPECT_EQ(now->at_pointer("/robot/gate_open"), false);
    EXPECT_EQ(now->at_pointer("/robot/unknown"), "") << "all is known";
    *rig.program.cell |= 1 + 4 * 3;
    co_await pass(200ms);
    now = co_await ask("stream.status");
    EXPECT_EQ(now->at_pointer("/robot/emergency_stop"), true);
    EXPECT_EQ(now->at_pointer("/reason"), "an emergency stop is pressed");
    EXPECT_EQ(now->at_pointer("/tool/number"), 3);
    *rig.program.cell += 1;  // of the gate alone
    co_await pass(200ms);
    now = co_await ask("stream.status");
    EXPECT_EQ(now->at_pointer("/robot/emergency_stop"), false);
    EXPECT_EQ(now->at_pointer("/robot/gate_open"), true);
    counts = false;
    co_await pass(1200ms);
    now = co_await ask("stream.status");
    EXPECT_TRUE(now->at_pointer("/robot/gate_open").is_null()) << "the word is old";
    EXPECT_EQ(fault_of(*co_await ask("cell.status")), "");
  });
}

TEST_F(AnArmedStream, GoesOnWhereTheStateOfTheRobotIsNotKnownAndShowsNoneThatIsOld) {
  play([this]() -> Wait {
    co_await armed();
    co_await pass(2s);
    robot.leave(10s);
    rig.program.mode = 4;
    co_await pass(2s);
    Answer now = co_await ask("cell.status");
    EXPECT_EQ(now->at("state"), "armed");
    EXPECT_EQ(fault_of(*now), "");
    EXPECT_EQ(now->at_pointer("/stream/state"), "correcting");
    EXPECT_TRUE(now->at_pointer("/stream/robot/emergency_stop").is_null());
    EXPECT_EQ(now->at_pointer("/stream/robot/mode"), "EXT") << "RSI tells it";
    EXPECT_TRUE(now->at_pointer("/stream/robot/override_percent").is_null()) << "which RSI does not";
    EXPECT_EQ(now->at_pointer("/stream/robot/unknown"), "the controller does not answer");
    co_await pass(12s);
    now = co_await ask("stream.status");
    EXPECT_EQ(now->at_pointer("/robot/emergency_stop"), false) << "it answers again";
    rig.program.mode.reset();
    EXPECT_TRUE(co_await ask("stream.disarm"));
    co_await pass(2s);
    now = co_await ask("stream.status");
    EXPECT_TRUE(now->at_pointer("/robot/mode").is_null()) << "nobody asks any more";
  });
}

TEST_F(AnArmedStream, TestsInEachProgramWhetherTheArmFollows) {
  play([this]() -> Wait {
    co_await frozen();
    rig.stuck.reset();
    co_await pass(5s);
    co_await expect_state("armed", "holding");
    co_await another_program();
    co_await expect_state("armed", "correcting");
    EXPECT_EQ(fault_of(*co_await ask("cell.status")), "");
  });
}

TEST_F(AnArmedStream, LooksWhichArmItIsWhereAProgramBeginsAndNotByTheToolsThatItTakesThen) {
  play([this]() -> Wait {
    const Eigen::Vector3d p_BF_mm = forward_kinematics(nominal_arm(), rig.q).translation();
    rig.rist = rsi::CartesianPose{.x_mm = p_BF_mm.x(), .y_mm = p_BF_mm.y(), .z_mm = p_BF_mm.z()};
    co_await armed();
    co_await pass(1s);
    rig.rist->z_mm += 200;  // a tool
    co_await pass(5s);
    co_await expect_state("armed", "correcting");
    co_await another_program();
    co_await expect_state("fault", "fault");
  });
  EXPECT_THAT(fault(), HasSubstr("it is another arm, or the program has a tool or a base"));
}

TEST_F(AnArmedStream, TellsTheProgramHowFarItIsCorrectedAndRampsOutWhereThatAsksForIt) {
  rig.program.ask = 0;
  play([this]() -> Wait {
    co_await armed();
    co_await pass(1s);
    EXPECT_EQ(rig.gain, 0);
    EXPECT_EQ(rig.largest_applied_deg(), 0);
    Answer now = co_await ask("stream.status");
    EXPECT_THAT(now->at("reason").as_string().c_str(), HasSubstr("does not ask to be corrected"));
    rig.program.ask = 1;
    co_await pass(config.stream.ramp / 2);
    EXPECT_THAT(*rig.gain, AllOf(testing::Ge(30), testing::Le(70)));
    co_await pass(config.stream.ramp);
    EXPECT_EQ(rig.gain, 100);
    EXPECT_GT(rig.largest_applied_deg(), 0);
    rig.program.ask = 0;
    co_await pass(config.stream.ramp + 100ms);
    EXPECT_EQ(rig.gain, 0);
    EXPECT_EQ(rig.largest_applied_deg(), 0);
    EXPECT_TRUE(co_await ask("stream.disarm"));
    co_await pass(100ms);
    EXPECT_EQ(rig.gain, rsi::kGainNotArmed);
  });
}

TEST_F(AnArmedStream, TellsTheProgramWhyItIsNotCorrected) {
  play([this]() -> Wait {
    co_await armed();
    co_await pass(2s);
    EXPECT_TRUE(co_await ask("model.deactivate"));
    co_await pass(2s);
    EXPECT_EQ(rig.gain, rsi::kGainNoModel);
    EXPECT_EQ(rig.largest_applied_deg(), 0);
    rig.stuck = rig.q + JointVector::Constant(6, 0.01);
    co_await pass(5s);
    EXPECT_EQ(rig.gain, rsi::kGainFault);
    EXPECT_FALSE(rig.stop) << "outside RSI_MOVECORR the bit would be an error";
  });
}

TEST_F(AnArmedStream, IsRampedOutWhereItIsDisarmedAndThenCorrectsNothing) {
  play([this]() -> Wait {
    co_await armed();
    co_await pass(2s);
    EXPECT_GT(rig.largest_applied_deg(), 0);
    const Answer answer = co_await ask("stream.disarm");
    EXPECT_TRUE(answer) << answer.error().message;
    EXPECT_EQ(rig.largest_applied_deg(), 0);
    co_await expect_state("disconnected", "off");
    co_await another_program();
    EXPECT_EQ(rig.largest_applied_deg(), 0);
  });
}

TEST_F(AnArmedStream, CannotBeDisarmedWhileItIsFrozenAndSaysAtOnceWhatIsToBeDoneFirst) {
  play([this]() -> Wait {
    co_await frozen();
    const Answer now = co_await ask("cell.status");
    EXPECT_EQ(control::json_text(now->at("allowed")), R"(["cell.acknowledge"])");
    const drivers::TimePoint asked = clock.now();
    const Answer answer = co_await ask("stream.disarm");
    EXPECT_FALSE(answer);
    EXPECT_EQ(clock.now(), asked);
    EXPECT_THAT(answer.error().message,
                AllOf(HasSubstr("cannot be ramped out"), HasSubstr("cell.acknowledge"),
                      HasSubstr("then stream.disarm")));
    EXPECT_NE(store->armed_since().value(), "") << "it still is";
    EXPECT_TRUE(co_await ask("cell.acknowledge"));
    EXPECT_TRUE(co_await ask("stream.disarm"));
    EXPECT_EQ(rig.largest_applied_deg(), 0);
    co_await expect_state("disconnected", "off");
  });
}

TEST_F(AnArmedStream, IsDisarmedWhereTheProgramThatFrozeItHasEnded) {
  play([this]() -> Wait {
    co_await frozen();
    sends = false;
    co_await pass(1s);
    const Answer now = co_await ask("cell.status");
    EXPECT_EQ(fault_of(*now), "") << "its correction went with it";
    EXPECT_THAT(now->at_pointer("/stream/reason").as_string().c_str(), HasSubstr("no program has RSI open"));
    EXPECT_TRUE(co_await ask("stream.disarm"));
    co_await expect_state("disconnected", "waiting");
    EXPECT_EQ(fault_of(*co_await ask("cell.status")), "");
  });
}

TEST_F(AnArmedStream, IsDisarmedAtOnceWhereNoProgramHasRsiOpen) {
  play([this]() -> Wait {
    co_await armed();
    co_await pass(2s);
    sends = false;
    co_await pass(2s);
    const drivers::TimePoint asked = clock.now();
    EXPECT_TRUE(co_await ask("stream.disarm"));
    EXPECT_LE(clock.now() - asked, 100ms);
  });
}

TEST_F(AnArmedStream, IsArmedAgainAfterTheDaemonHasEndedUntilItIsDisarmed) {
  sends = false;
  play([this]() -> Wait { co_await armed(); });
  EXPECT_EQ(state_under_next_daemon(), "armed");
  play([this]() -> Wait { EXPECT_TRUE(co_await ask("stream.disarm")); });
  EXPECT_EQ(state_under_next_daemon(), "disconnected");
}

TEST_F(AnArmedStream, IsNotArmedByADaemonThatCannotUseItsModel) {
  sends = false;
  play([this]() -> Wait { co_await armed(); });
  alter_m1();
  load();
  arm_as_before(cell);
  EXPECT_EQ(store->armed_since().value(), "");
}

TEST_F(AnArmedStream, IsNotArmedForAnotherArmWhoseStateServerTellsItsNumber) {
  play([this]() -> Wait {
    co_await ask("cell.disconnect");
    robot.set_serial("MOCK-0002");
    const Answer answer = co_await ask("stream.arm");
    EXPECT_FALSE(answer);
    EXPECT_THAT(answer.error().message, HasSubstr("belongs to arm MOCK-0001, not to MOCK-0002"));
    co_await expect_state("disconnected", "off");
  });
}

TEST_F(AnArmedStream, TakesNoToolIntoUseThatWasMeasuredOnAnotherArm) {
  CampaignRecord measured{.id = "t1", .kind = "tool", .state = "done"};
  measured.robot_serial = "MOCK-0002";
  ASSERT_TRUE(store->begin_campaign(measured));
  ASSERT_TRUE(store->end_campaign(measured));
  robot.set_serial("MOCK-0001");
  play([this]() -> Wait {
    co_await armed();
    co_await pass(2s);
    json::object params;
    params["id"] = "t1";
    const Answer answer = co_await ask("tool.activate", params);
    EXPECT_FALSE(answer);
    EXPECT_EQ(answer.error().message, "the tool belongs to arm MOCK-0002, not to MOCK-0001");
  });
}

TEST_F(AnArmedStream, EndsWithAFaultWhereTheStateServerTellsAnotherArm) {
  robot.set_serial("MOCK-0001");
  play([this]() -> Wait {
    co_await armed();
    co_await pass(2s);
    Answer now = co_await ask("stream.status");
    EXPECT_EQ(now->at_pointer("/arm/serial"), "MOCK-0001");
    EXPECT_EQ(now->at_pointer("/arm/verified"), true);
    robot.set_serial("MOCK-0002");
    co_await pass(4s);
    co_await expect_state("fault", "off");
    EXPECT_EQ(rig.largest_applied_deg(), 0) << "ramped out";
  });
  EXPECT_THAT(fault(), HasSubstr("belongs to arm MOCK-0001, not to MOCK-0002"));
  EXPECT_EQ(store->armed_since().value(), "");
}

TEST_F(AnArmedStream, DoesNotCorrectAControllerThatWasAwayBeforeItsSerialNumberIsKnown) {
  robot.set_serial("MOCK-0001");
  play([this]() -> Wait {
    co_await armed();
    co_await pass(2s);
    EXPECT_GT(rig.largest_applied_deg(), 0);
    co_await another_program();
    EXPECT_GT(rig.largest_applied_deg(), 0) << "its state server was there all the time";
    sends = false;
    robot.leave(20s);
    co_await pass(10s);
    rig.restart(rig.ipoc + 1000);
    sends = true;
    co_await pass(5s);
    EXPECT_EQ(rig.largest_applied_deg(), 0);
    EXPECT_EQ(rig.gain, rsi::kGainNotArmed);
    Answer now = co_await ask("cell.status");
    EXPECT_EQ(now->at("state"), "armed");
    EXPECT_EQ(now->at_pointer("/faults/0/code"), "E_ARM");
    EXPECT_EQ(now->at_pointer("/stream/arm/verified"), false);
    EXPECT_THAT(now->at_pointer("/stream/reason").as_string().c_str(), HasSubstr("does not answer"));
    co_await pass(10s);
    co_await expect_state("armed", "correcting");
    now = co_await ask("cell.status");
    EXPECT_EQ(fault_of(*now), "");
    EXPECT_EQ(now->at_pointer("/stream/arm/verified"), true);
  });
}

TEST_F(AnArmedStream, CorrectsAControllerThatNeverTellsWhoseItIsAndSaysThatNobodyKnows) {
  play([this]() -> Wait {
    co_await armed();
    co_await pass(2s);
    Answer now = co_await ask("stream.status");
    EXPECT_EQ(now->at_pointer("/arm/verified"), true) << "it was connected until it was armed";
    co_await another_program();
    co_await expect_state("armed", "correcting");
    now = co_await ask("stream.status");
    EXPECT_EQ(now->at_pointer("/arm/verified"), false);
    EXPECT_THAT(now->at_pointer("/arm/why_not").as_string().c_str(),
                AllOf(HasSubstr("MOCK-0001"), HasSubstr("truepose_state"), HasSubstr("connect")));
  });
}

TEST_F(AnArmedStream, IsNotArmedAgainForAnotherArm) {
  sends = false;
  play([this]() -> Wait { co_await armed(); });
  robot.set_serial("MOCK-0002");
  EXPECT_EQ(state_under_next_daemon(), "disconnected");
  EXPECT_EQ(store->armed_since().value(), "");
}

TEST_F(AnArmedStream, NeedsAModel) {
  EXPECT_TRUE(call("model.deactivate"));
  EXPECT_THAT(refused("stream.arm"), HasSubstr("no model"));
  EXPECT_EQ(store->armed_since().value(), "");
}

TEST_F(AnArmedStream, StaysArmedWhateverASessionCameToThatIsOver) {
  play([this]() -> Wait {
    rig.rist = rsi::CartesianPose{.x_mm = 1};  // of another arm; the stream is not armed
    co_await pass(2s);
    EXPECT_EQ(rig.cycle->status().state, StreamState::Fault);
    sends = false;
    co_await pass(5s);
    rig.rist.reset();
    co_await armed();
    co_await pass(2s);
    co_await expect_state("armed", "waiting");
    co_await another_program();
    co_await expect_state("armed", "correcting");
  });
}

TEST_F(AnArmedStream, IsArmedAgainByAPersonAfterAFault) {
  play([this]() -> Wait {
    co_await armed();
    co_await pass(2s);
    rig.rist = rsi::CartesianPose{.x_mm = 1};  // of another arm
    co_await pass(2s);
    co_await expect_state("fault", "fault");
  });
  EXPECT_EQ(store->armed_since().value(), "");
}

}  // namespace
}  // namespace truepose::daemon
