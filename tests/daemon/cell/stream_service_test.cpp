#include "daemon/cell/stream_service.hpp"

#include <boost/json/parse.hpp>

#include "tests/daemon/watched_stream.hpp"

namespace truepose::daemon {
namespace {

namespace asio = boost::asio;
namespace json = boost::json;
using testing::AllOf;
using testing::HasSubstr;
using namespace std::chrono_literals;

TEST_F(AWatchedStream, IsAFaultHalfASecondAfterItsControllerFellSilent) {
  play([this]() -> Wait {
    const auto started = co_await ask("stream.start");
    EXPECT_TRUE(started) << started.error().message;
    co_await pass(2s);
    auto now = co_await ask("cell.status");
    EXPECT_EQ(now->at("state"), "streaming");
    EXPECT_EQ(now->at_pointer("/stream/state"), "correcting") << control::json_text(now->at("stream"));
    sends = false;
    co_await pass(500ms);
    now = co_await ask("cell.status");
    EXPECT_EQ(now->at("state"), "fault");
    EXPECT_NE(now->at_pointer("/stream/state"), "correcting");
    EXPECT_THAT(fault_of(*now), HasSubstr("has sent no RSI packet for 0."));
    EXPECT_EQ(now->at_pointer("/stream/reason").as_string(), fault_of(*now));
  });
}

TEST_F(AWatchedStream, DoesNotBlameTheControllerWhereThisMachineDoesNotRead) {
  play([this]() -> Wait {
    const auto started = co_await ask("stream.start");
    EXPECT_TRUE(started) << started.error().message;
    co_await pass(2s);
    sends = read = false;
    co_await pass(1s);
    auto now = co_await ask("cell.status");
    EXPECT_EQ(now->at("state"), "streaming");
    EXPECT_EQ(now->at_pointer("/stream/state"), "waiting") << "nothing is corrected";
    EXPECT_THAT(std::string{now->at_pointer("/stream/reason").as_string()},
                HasSubstr("this PC has not run truepose's RSI thread for 1.0 s"));
    read = true;
    co_await pass(100ms);
    now = co_await ask("cell.status");
    EXPECT_THAT(fault_of(*now), HasSubstr("the controller has sent no RSI packet for 1."));
  });
}

TEST_F(AWatchedStream, SaysWhatToLookAtWhereNoPacketComes) {
  sends = false;
  config.stream.ethernet_xml = "/cell/rsi_ethernet.xml";
  play([this]() -> Wait {
    const drivers::TimePoint asked = clock.now();
    const auto started = co_await ask("stream.start");
    EXPECT_FALSE(started);
    EXPECT_LE(clock.now() - asked, 5s);
    EXPECT_THAT(started.error().message,
                AllOf(HasSubstr("no packet came to"), HasSubstr("IP_NUMBER and PORT"), HasSubstr("RSI_ON"),
                      HasSubstr("RSITimeout"), HasSubstr("/cell/rsi_ethernet.xml")));
  });
}

TEST_F(AWatchedStream, SaysWhatIsWrongWithTheControllersPacketsWhileItStillWaitsForGoodOnes) {
  garbled = true;
  play([this]() -> Wait {
    bool started = false;
    asio::co_spawn(
        io,
        [&]() -> Wait {
          const Answer refused = co_await ask("stream.start");
          EXPECT_THAT(refused.error().message,
                      AllOf(HasSubstr("none was understood"), HasSubstr("127.0.0.1:40000")));
          started = true;
        },
        asio::detached);
    co_await pass(2s);
    auto now = co_await ask("stream.status");
    EXPECT_EQ(now->at("state"), "waiting");
    EXPECT_THAT(now->at("reason").as_string().c_str(),
                AllOf(HasSubstr("none was understood"), HasSubstr("ASPos is missing"),
                      HasSubstr(config.stream.ethernet_xml)));
    while (!started) co_await pass(100ms);
    now = co_await ask("cell.status");
    EXPECT_EQ(now->at_pointer("/stream/state"), "off");
    EXPECT_EQ(now->at_pointer("/stream/reason").as_string(), fault_of(*now));
  });
}

TEST_F(AWatchedStream, TellsThatTheRobotIsGoneWhileItStreams) {
  play([this]() -> Wait {
    const auto started = co_await ask("stream.start");
    EXPECT_TRUE(started);
    robot.disconnect();
    co_await pass(2s);
    const auto now = co_await ask("cell.status");
    EXPECT_EQ(now->at("state"), "fault");
    EXPECT_EQ(now->at_pointer("/robot/connected"), false);
  });
}

TEST_F(AWatchedStream, GoesOnWithoutItsTrackerAndSaysSo) {
  play([this]() -> Wait {
    const auto started = co_await ask("stream.start");
    EXPECT_TRUE(started);
    tracker.disconnect();
    co_await pass(7s);
    const auto now = co_await ask("cell.status");
    EXPECT_EQ(now->at_pointer("/stream/state"), "correcting") << control::json_text(now->at("stream"));
    EXPECT_EQ(now->at_pointer("/tracker/connected"), false);
    EXPECT_THAT(fault_of(*now), HasSubstr("the stream continues without it"));
  });
}

TEST_F(AWatchedStream, RampsTheCorrectionOutAndIsReadyOnceItIsStopped) {
  play([this]() -> Wait {
    co_await streaming();
    EXPECT_GT(rig.largest_applied_deg(), 0);
    const TimePoint asked = clock.now();
    const Answer stopped = co_await ask("stream.stop");
    EXPECT_TRUE(stopped) << stopped.error().message;
    EXPECT_GE(clock.now() - asked, config.stream.ramp);
    EXPECT_EQ(rig.largest_applied_deg(), 0);
    const Answer now = co_await ask("cell.status");
    EXPECT_EQ(now->at("state"), "ready");
    EXPECT_EQ(now->at_pointer("/stream/state"), "off");
  });
  EXPECT_THAT(event_data(control::Topic::Stream).size(), testing::Gt(3U)) << "each second, and each change";
}

TEST_F(AWatchedStream, EndsItsProgramByTheStopBit) {
  leaves = true;
  play([this]() -> Wait {
    co_await streaming();
    const TimePoint asked = clock.now();
    const Answer stopped = co_await ask("stream.stop");
    EXPECT_TRUE(stopped) << stopped.error().message;
    EXPECT_FALSE(sends);
    EXPECT_LT(clock.now() - asked, config.stream.ramp + 1s) << "nothing else was waited for";
  });
}

TEST_F(AWatchedStream, SaysThatItWaitsForTheControllersProgramAndThenForItsPackets) {
  sends = false;
  play([this]() -> Wait {
    send("stream.start");
    co_await pass(50ms);
    Answer now = co_await ask("cell.status");
    EXPECT_EQ(now->at_pointer("/waiting/device"), "controller");
    EXPECT_EQ(now->at_pointer("/waiting/reason"), "its RSI program has to start");
    co_await pass(1s);
    now = co_await ask("cell.status");
    EXPECT_EQ(now->at_pointer("/waiting/reason"), "its RSI packets have to come");
    sends = true;
    co_await pass(1s);
    now = co_await ask("cell.status");
    EXPECT_TRUE(now->at("waiting").is_null());
  });
}

TEST_F(AWatchedStream, IsNotStartedWhereTheControllersProgramCannotBe) {
  sends = false;
  play([this]() -> Wait {
    co_await pass(500ms);  // no question to the controller is under way, which would show the loss first
    robot.disconnect();
    const Answer started = co_await ask("stream.start");
    EXPECT_FALSE(started);
    EXPECT_EQ(started.error().code, control::ErrorCode::Device);
    EXPECT_THAT(started.error().message,
                AllOf(testing::StartsWith("robot: not connected; look on the pendant"),
                      testing::EndsWith("then acknowledge the fault, connect and start the stream")));
    const Answer now = co_await ask("cell.status");
    EXPECT_EQ(now->at_pointer("/stream/reason").as_string(), started.error().message);
  });
}

TEST_F(AWatchedStream, CanBeStoppedBeforeAPacketCame) {
  sends = false;
  play([this]() -> Wait {
    send("stream.start");
    co_await pass(1s);
    send("stream.stop");
    co_await pass(1s);
    const Answer now = co_await ask("cell.status");
    EXPECT_NE(now->at("state"), "streaming");
  });
}

TEST_F(AWatchedStream, SaysThatTheControllerHasAnotherCycle) {
  rig.step = 12;
  play([this]() -> Wait {
    const Answer started = co_await ask("stream.start");
    EXPECT_FALSE(started);
    EXPECT_THAT(started.error().message,
                AllOf(HasSubstr("IPOC rises by 12"), HasSubstr("stream.cycle_ms is 4")));
    const Answer now = co_await ask("cell.status");
    EXPECT_EQ(fault_of(*now), started.error().message);
    EXPECT_EQ(now->at_pointer("/stream/reason").as_string(), started.error().message);
  });
}

TEST_F(AWatchedStream, WaitsForASilentControllerWhereItGoesOnByItself) {
  config.stream.rearm = config::Rearm::Automatic;
  play([this]() -> Wait {
    co_await streaming();
    sends = false;
    co_await pass(1s);
    Answer now = co_await ask("cell.status");
    EXPECT_EQ(now->at("state"), "streaming");
    EXPECT_EQ(now->at_pointer("/faults/0/code"), "E_STREAM_TIMEOUT");
    EXPECT_EQ(now->at_pointer("/waiting/device"), "controller");
    sends = true;
    co_await pass(200ms);
    now = co_await ask("cell.status");
    EXPECT_EQ(fault_of(*now), "");
    EXPECT_TRUE(now->at("waiting").is_null());
  });
}

/// What stands between a stream and its end.
struct AFrozenStream : AWatchedStream {
  Wait frozen() {
    co_await streaming();
    rig.stuck = rig.q;
    co_await pass(5s);
    const Answer now = co_await ask("cell.status");
    EXPECT_EQ(now->at_pointer("/faults/0/code"), "E_STREAM_FROZEN");
    EXPECT_EQ(now->at_pointer("/stream/state"), "holding");
    EXPECT_EQ(control::json_text(now->at("allowed")), R"(["cell.acknowledge"])") << "alone";
  }
  Wait expect_stopped() {
    const Answer stopped = co_await ask("stream.stop");
    EXPECT_TRUE(stopped) << stopped.error().message;
    EXPECT_EQ(rig.largest_applied_deg(), 0);
    const Answer now = co_await ask("cell.status");
    EXPECT_EQ(now->at("state"), "ready");
    EXPECT_EQ(now->at_pointer("/stream/state"), "off");
    EXPECT_EQ(fault_of(*now), "");
  }
};

TEST_F(AFrozenStream, CannotBeStoppedAndSaysAtOnceWhatIsToBeDoneFirst) {
  play([this]() -> Wait {
    co_await frozen();
    const drivers::TimePoint asked = clock.now();
    const Answer stopped = co_await ask("stream.stop");
    EXPECT_FALSE(stopped);
    EXPECT_EQ(clock.now(), asked);
    EXPECT_EQ(stopped.error().code, control::ErrorCode::WrongState);
    EXPECT_THAT(stopped.error().message,
                AllOf(HasSubstr("correction cannot be ramped out"), HasSubstr("axes do not follow"),
                      HasSubstr("cell.acknowledge"), HasSubstr("then stream.stop"), HasSubstr("pendant")));
    EXPECT_THAT(stopped.error().allowed, testing::ElementsAre("cell.acknowledge"));
    EXPECT_GT(rig.largest_applied_deg(), 0);
    EXPECT_TRUE(co_await ask("cell.acknowledge"));
    co_await expect_stopped();
  });
}

TEST_F(AFrozenStream, SaysThatItIsNotStoppedWhereItFreezesOnTheWay) {
  config.stream.ramp = 10s;
  play([this]() -> Wait {
    co_await streaming();
    co_await pass(10s);
    rig.stuck = rig.q + JointVector::Constant(6, 0.02);
    const drivers::TimePoint asked = clock.now();
    const Answer stopped = co_await ask("stream.stop");
    EXPECT_LT(clock.now() - asked, 5s);
    EXPECT_FALSE(stopped);
    EXPECT_THAT(stopped.error().message, HasSubstr("correction cannot be ramped out"));
    rig.stuck.reset();
    EXPECT_TRUE(co_await ask("cell.acknowledge"));
    co_await pass(12s);
    const Answer now = co_await ask("cell.status");
    EXPECT_EQ(now->at("state"), "ready") << "the ramp that was asked for has gone on";
    EXPECT_EQ(rig.largest_applied_deg(), 0);
  });
}

TEST_F(AFrozenStream, IsGivenUpByEndingItsProgramOnThePendant) {
  play([this]() -> Wait {
    co_await frozen();
    sends = false;
    co_await pass(1s);
    Answer now = co_await ask("cell.status");
    EXPECT_EQ(now->at("state"), "fault");
    EXPECT_TRUE(co_await ask("cell.acknowledge"));
    co_await pass(200ms);
    now = co_await ask("cell.status");
    EXPECT_EQ(now->at("state"), "disconnected");
    EXPECT_EQ(fault_of(*now), "");
    EXPECT_NE(now->at_pointer("/stream/state"), "holding");
  });
}

TEST_F(AFrozenStream, CanBeAcknowledgedInAnyStateThatItOutlives) {
  play([this]() -> Wait {
    co_await frozen();
    robot.disconnect();
    co_await pass(2s);
    EXPECT_TRUE(co_await ask("cell.acknowledge")) << "of the robot that is gone";
    rig.cycle->engage();  // what is left in effect does not arrive
    co_await pass(5s);
    Answer now = co_await ask("cell.status");
    EXPECT_EQ(now->at("state"), "disconnected");
    EXPECT_EQ(now->at_pointer("/faults/0/code"), "E_STREAM_FROZEN");
    EXPECT_THAT(control::json_text(now->at("allowed")), HasSubstr("cell.acknowledge"));
    rig.cycle->disengage();
    EXPECT_TRUE(co_await ask("cell.acknowledge"));
    co_await pass(config.stream.ramp + 100ms);
    now = co_await ask("cell.status");
    EXPECT_EQ(fault_of(*now), "");
    EXPECT_EQ(rig.largest_applied_deg(), 0);
  });
}

TEST_F(AWatchedStream, WarnsOfACorrectionThatItDoesNotKnowAsLongAsItsSessionLasts) {
  play([this]() -> Wait {
    rig.applied = axes_deg({1, 0, 0, 0, 0, 0});  // by a daemon before
    for (int cycle = 0; cycle < 500; ++cycle) {
      rig.q[0] += 0.0005;
      co_await pass(4ms);
    }
    Answer now = co_await ask("cell.status");
    EXPECT_EQ(now->at_pointer("/faults/0/code"), "E_STREAM_UNCONFIRMED");
    sends = false;
    co_await pass(1s);
    now = co_await ask("cell.status");
    EXPECT_EQ(now->at("state"), "ready");
    EXPECT_EQ(fault_of(*now), "");
  });
}

TEST_F(AWatchedStream, IsRefusedAtOnceWhileAnEmergencyStopIsPressedAndTheDevicesStay) {
  play([this]() -> Wait {
    robot.press_emergency_stop(true);
    const TimePoint asked = clock.now();
    const Answer refused = co_await ask("stream.start");
    EXPECT_THAT(refused.error().message,
                AllOf(HasSubstr("robot: emergency stop: release it"),
                      HasSubstr("start truepose_motion there"), HasSubstr("then start the stream")));
    EXPECT_LT(clock.now() - asked, 1s);
    co_await pass(10s);
    const Answer now = co_await ask("cell.status");
    EXPECT_EQ(now->at("state"), "ready");
    EXPECT_EQ(now->at_pointer("/robot/connected"), true);
    EXPECT_EQ(now->at_pointer("/tracker/connected"), true);
    EXPECT_EQ(fault_of(*now), "");
  });
}

TEST_F(AWatchedStream, HoldsWhileItsProgramIsStoppedAndGoesOnWithIt) {
  rig.program.state = rsi::kProgramActive;
  play([this]() -> Wait {
    co_await streaming();
    const JointVector before = rig.applied;
    rig.program.state = 4;
    rig.stuck = rig.q;  // drives are off: whatever is sent, nothing moves
    robot.press_emergency_stop(true);
    co_await pass(1min);
    EXPECT_EQ(rig.applied, before);
    Answer now = co_await ask("cell.status");
    EXPECT_EQ(fault_of(*now), "");
    EXPECT_EQ(now->at_pointer("/stream/state"), "holding");
    EXPECT_THAT(now->at_pointer("/stream/reason").as_string().c_str(),
                AllOf(HasSubstr("emergency stop is pressed"), HasSubstr("correction is held")));
    EXPECT_TRUE(now->at_pointer("/stream/measured_deg/0").is_null());
    robot.press_emergency_stop(false);
    rig.stuck.reset();
    rig.program.state = rsi::kProgramActive;
    co_await pass(2s);
    now = co_await ask("cell.status");
    EXPECT_EQ(now->at_pointer("/stream/state"), "correcting");
    EXPECT_EQ(fault_of(*now), "");
  });
}

TEST_F(AWatchedStream, SaysFromWherePacketsCameThatAreNotTheControllers) {
  config.robot.rsi_peer = "127.0.0.1";
  rig.source = {0x7f000002, 40'000};
  play([this]() -> Wait {
    const Answer started = co_await ask("stream.start");
    EXPECT_FALSE(started);
    EXPECT_THAT(
        started.error().message,
        AllOf(HasSubstr(" packets came to "), HasSubstr("not from the controller (127.0.0.1)"),
              HasSubstr("the last new sender is 127.0.0.2:40000"), HasSubstr("give it as robot.rsi_peer")));
  });
}

TEST_F(AWatchedStream, NamesPacketsThatAreNotTheControllers) {
  play([this]() -> Wait {
    co_await streaming();
    rig.send("<Rob/>", {0x7f000002, 50'000});
    co_await pass(100ms);
    const Answer now = co_await ask("stream.status");
    EXPECT_EQ(now->at("unexpected_sender"), 1);
    EXPECT_THAT(std::string{now->at("refused").as_string()}, HasSubstr("127.0.0.2:50000"));
  });
}

TEST_F(AWatchedStream, RampsOutBeforeTheDaemonEnds) {
  play([this]() -> Wait {
    co_await streaming();
    const TimePoint asked = clock.now();
    co_await cell.shut_down();
    EXPECT_EQ(rig.largest_applied_deg(), 0);
    EXPECT_LT(clock.now() - asked, config.stream.ramp + 500ms) << "no longer than that takes";
  });
  EXPECT_FALSE(robot.connected());
}

TEST(StreamStatusAnswer, SaysCorrectingOfAStreamThatHasAModelAlone) {
  const auto reported = [](std::uint64_t model, double a1_deg) {
    StreamStatus status;
    status.state = StreamState::Active;
    status.model = model;
    status.correction_deg[0] = a1_deg;
    return stream_status(
        status, {},
        {.streaming = true, .age = drivers::Duration{0}, .refused = "", .trouble = "", .model_id = ""});
  };
  EXPECT_EQ(reported(1, 0.5).state, "correcting");
  EXPECT_EQ(reported(0, 0.5).state, "ramping") << "out of the model that was in force";
  EXPECT_EQ(reported(0, 0).state, "waiting");
  EXPECT_THAT(reported(0, 0).reason, HasSubstr("no model is active"));
}

TEST(StreamStatusAnswer, TellsOfItsThreadWhatTheKernelDoes) {
  const auto reported = [](const std::optional<drivers::Scheduling>& thread) {
    StreamStatus status;
    status.counters.late_by_machine = 2;
    const StreamTimes times{.turnaround = {.p50_us = 50, .max_us = 90},
                            .compute = {.p50_us = 7, .max_us = 9}};
    return stream_status(status, times, {.refused = "", .trouble = "", .model_id = "", .thread = thread});
  };
  const json::value known = record::to_json(
      reported(drivers::Scheduling{.policy = "SCHED_FIFO", .priority = 80, .cpus = {3}, .locked_kB = 64}));
  EXPECT_EQ(known.at("scheduling"),
            json::parse(R"({"policy": "SCHED_FIFO", "priority": 80, "cpus": [3], "locked_kB": 64})"));
  EXPECT_EQ(known.at("late_by"), json::parse(R"({"daemon": 0, "machine": 2, "network": 0})"));
  EXPECT_EQ(known.at_pointer("/turnaround_us/max"), 90.0);
  EXPECT_EQ(known.at_pointer("/compute_us/p50"), 7.0);
  EXPECT_TRUE(record::to_json(reported(std::nullopt)).at("scheduling").is_null());
}

TEST(StreamStatusAnswer, SaysOfAControllerThatIsSilentThatItIsBeforeWhatIsNotKnownOfIt) {
  const auto reason = [](drivers::Duration age, const std::string& trouble) {
    StreamStatus status;
    status.state = StreamState::Unproven;
    status.heard = drivers::TimePoint{};
    status.read_until = drivers::TimePoint{age};
    return stream_status(
               status, {},
               {.streaming = trouble.empty(), .age = age, .refused = "", .trouble = trouble, .model_id = ""})
        .reason;
  };
  EXPECT_THAT(reason(4ms, ""), HasSubstr("as soon as the arm stands"));
  EXPECT_THAT(reason(1s, ""), HasSubstr("has sent no RSI packet for 1.0 s"));
  EXPECT_EQ(reason(1s, "what ended the stream"), "what ended the stream");
}

TEST(StreamStatusAnswer, ShowsNothingOfTheRobotThatIsNotKnown) {
  const json::object reported =
      record::to_json(stream_status({}, {}, {.robot = {.program = "active", .unknown = "refused"}}));
  const json::object& robot = reported.at("robot").as_object();
  for (const char* key : {"mode", "override_percent", "emergency_stop", "gate_open"})
    EXPECT_TRUE(robot.at(key).is_null()) << key;
  EXPECT_EQ(robot.at("program"), "active");
  EXPECT_EQ(robot.at("unknown"), "refused");
}

}  // namespace
}  // namespace truepose::daemon
