#include "drivers/kuka/eki_robot.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <boost/asio/awaitable.hpp>
#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "core/math/angles.hpp"
#include "tests/drivers/eki_controller.hpp"

namespace truepose::drivers {
namespace {

namespace asio = boost::asio;
using namespace std::chrono_literals;
using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using enum eki::AckState;

TEST_F(EkiRobot, ConnectsAndSaysWhichArmItIs) {
  serve({greet_and_answer({})});
  run([&](KukaEkiRobot& robot) -> asio::awaitable<void> {
    const auto identity = co_await robot.connect(soon());
    EXPECT_TRUE(identity) << identity.error().detail;
    if (!identity) co_return;
    EXPECT_EQ(identity->model, "#KR210R2700_2 C4 FLR");
    EXPECT_EQ(identity->serial, "864213");
    EXPECT_EQ(identity->software, "KSS 8.6.11");
  });
  EXPECT_THAT(controls_, Contains(eki::ControlOp::ReleaseStop));
}

TEST_F(EkiRobot, IsInspectedWithoutReleasingAStop) {
  serve({greet_and_answer({})});
  run([&](KukaEkiRobot& robot) -> asio::awaitable<void> {
    const auto identity = co_await robot.inspect(soon());
    EXPECT_TRUE(identity) << identity.error().detail;
  });
  EXPECT_THAT(controls_, ElementsAre(eki::ControlOp::AskState));
}

TEST_F(EkiRobot, LetsItsTapHearAllThatGoesOverTheWire) {
  using recording::Kind;
  std::vector<eki::Command> seen;
  serve({greet_and_answer({InPosition}, 0, &seen)});
  run([&](KukaEkiRobot& robot) -> asio::awaitable<void> {
    co_await robot.connect(soon());
    co_await robot.move({target()}, soon());
    robot.disconnect();
  });
  ASSERT_EQ(seen.size(), 1U);
  std::string received, sent, kinds;
  for (const auto& [kind, bytes] : heard_) {
    kinds += kind == Kind::Connected ? "c" : kind == Kind::Sent ? "s" : kind == Kind::Closed ? "x" : "r";
    if (kind == Kind::Received) received += bytes;
    if (kind == Kind::Sent) sent += bytes;
  }
  EXPECT_EQ(sent, eki::encode(eki::ToController{seen[0]}));
  EXPECT_EQ(received, text(kHello) + text(ack(seen[0], InPosition)));
  EXPECT_EQ(kinds, "crsrx");
  EXPECT_THAT(heard_.front().second, testing::ContainsRegex("^127.0.0.1:[0-9]+ 127.0.0.1:[0-9]+$"));
}

TEST_F(EkiRobot, ReportsItsStateInRadAndAsAPose) {
  serve({greet_and_answer({})});
  run([&](KukaEkiRobot& robot) -> asio::awaitable<void> {
    co_await robot.connect(soon());
    const auto state = co_await robot.state(soon());
    EXPECT_TRUE(state && state->ready) << state->why_not_ready;
    EXPECT_FALSE(state->moving);
    EXPECT_NEAR(state->q[1], -90 * kRadPerDeg, 1e-8);
    EXPECT_TRUE(state->X_BF_reported.isApprox(pose_from_kuka({1765, 0, 1910}, {0, 90, 0}), 1e-9));
    EXPECT_EQ(state->override_percent, 40);
    state_.drives_ready = false;
    const auto off = co_await robot.state(soon());
    EXPECT_FALSE(off->ready);
    EXPECT_EQ(off->why_not_ready, "drives off");
    state_.no_emergency_stop = false;
    const auto pressed = co_await robot.state(soon());
    EXPECT_EQ(pressed->why_not_ready, "emergency stop");
    state_ = ready_state(0);
    state_.mode = eki::OperatingMode::Ext;
    state_.gate_closed = false;
    const auto open = co_await robot.state(soon());
    EXPECT_EQ(open->why_not_ready, "safety gate open");
    state_.mode = eki::OperatingMode::T1;
    const auto jogged = co_await robot.state(soon());
    EXPECT_TRUE(jogged->ready) << "the gate may be open in T1";
    state_ = ready_state(0);
    state_.tool = 3;
    const auto tool = co_await robot.state(soon());
    EXPECT_THAT(tool->why_not_ready, HasSubstr("tool 3 is active"));
  });
}

TEST_F(EkiRobot, LooksByTheStateServerAloneAndReleasesNoStop) {
  serve({});
  run([&](KukaEkiRobot& robot) -> asio::awaitable<void> {
    state_.mode = eki::OperatingMode::Aut;
    state_.program = eki::ProgramState::Stopped;
    state_.no_emergency_stop = false;
    state_.gate_closed = false;
    const auto seen = co_await robot.look(soon());
    EXPECT_TRUE(seen) << seen.error().detail;
    EXPECT_EQ(seen->mode, "AUT");
    EXPECT_EQ(seen->program, "stopped");
    EXPECT_TRUE(seen->emergency_stop);
    EXPECT_TRUE(seen->gate_open);
    state_ = ready_state(0);
    const auto later = co_await robot.look(soon());
    EXPECT_FALSE(later->emergency_stop);
    robot.disconnect();
    state_acceptor_.close();
    const auto refused = co_await robot.look(soon());
    EXPECT_THAT(refused.error().detail, HasSubstr("the state server (sps.sub)"));
  });
  EXPECT_THAT(controls_, testing::ElementsAre(eki::ControlOp::AskState, eki::ControlOp::AskState));
}

TEST_F(EkiRobot, ComesAgainToAControllerThatHasNotYetSeenItsLastClientGo) {
  const Script drop = [](std::shared_ptr<Peer> peer) -> asio::awaitable<void> {
    peer->close();
    co_return;
  };
  int taken = 0;
  serve({drop, greet_and_answer({})}, [&, answer = answer_with_state()](std::shared_ptr<Peer> peer) {
    return ++taken == 1 ? drop(peer) : answer(peer);
  });
  run([&](KukaEkiRobot& robot) -> asio::awaitable<void> {
    const auto identity = co_await robot.connect(soon());
    EXPECT_TRUE(identity) << identity.error().detail;
  });
  EXPECT_EQ(taken, 2);
}

TEST_F(EkiRobot, MovesAndReturnsTheActualJointsWhenTheArmHasSettled) {
  std::vector<eki::Command> seen;
  serve({greet_and_answer({Accepted, Moving, InPosition}, 0, &seen)});
  run([&](KukaEkiRobot& robot) -> asio::awaitable<void> {
    co_await robot.connect(soon());
    const auto first = co_await robot.move({target(), 35, 250ms}, soon());
    EXPECT_TRUE(first) << first.error().detail;
    EXPECT_TRUE(first->isApprox(target(), 1e-7));
    const auto second = co_await robot.move({target(), 35, 250ms}, soon());
    EXPECT_TRUE(second);
  });
  ASSERT_EQ(seen.size(), 2u);
  EXPECT_EQ(seen[0].velocity_percent, 35);
  EXPECT_EQ(seen[0].settle_ms, 250);
  EXPECT_GT(seen[1].id, seen[0].id) << "a finished move is not the same command";
}

TEST_F(EkiRobot, PassesOverAcksOfOtherCommandsAndTagsOfOtherMessages) {
  serve({[](std::shared_ptr<Peer> peer) -> asio::awaitable<void> {
    co_await peer->write(text(kHello));
    const eki::ToController message = co_await peer->read();
    eki::Command command = std::get<eki::Command>(message);
    eki::Command other = command;
    other.id -= 1;
    // Coalesced, padded, and cut in the middle of a tag.
    const std::string stream = text(ack(other, Rejected)) + std::string(100, '\0') + text(kHello) + "\r\n" +
                               text(ack(command, Accepted)) + text(ack(command, InPosition));
    for (const char& c : stream) co_await peer->write(std::string(1, c));
  }});
  run([&](KukaEkiRobot& robot) -> asio::awaitable<void> {
    co_await robot.connect(soon());
    const auto q = co_await robot.move({target()}, soon());
    EXPECT_TRUE(q) << q.error().detail;
  });
}

TEST_F(EkiRobot, UnderstandsAControllerThatSendsEveryTagWithEveryDocument) {
  serve({[](std::shared_ptr<Peer> peer) -> asio::awaitable<void> {
    const auto with_tags = [](std::string document, const std::string& tags) {
      return document.insert(document.find('>') + 1, tags);
    };
    co_await peer->write(with_tags(
        text(kHello), R"(<Ack Id="" State="" Err=""><Ax A1="" A2="" A3="" A4="" A5="" A6=""></Ax></Ack>)"));
    const eki::ToController message = co_await peer->read();
    const eki::Command command = std::get<eki::Command>(message);
    co_await peer->write(
        with_tags(text(ack(command, InPosition)), R"(<Hello Ver="1" Model="" Serial="" KssVer=""/>)"));
  }});
  run([&](KukaEkiRobot& robot) -> asio::awaitable<void> {
    const auto identity = co_await robot.connect(soon());
    EXPECT_TRUE(identity) << identity.error().detail;
    const auto q = co_await robot.move({target()}, soon());
    EXPECT_TRUE(q) << q.error().detail;
  });
}

TEST_F(EkiRobot, SaysWhyAMoveWasRejected) {
  serve({greet_and_answer({Rejected}, static_cast<int>(eki::AckError::OutOfRange))});
  run([&](KukaEkiRobot& robot) -> asio::awaitable<void> {
    co_await robot.connect(soon());
    const auto q = co_await robot.move({target()}, soon());
    EXPECT_EQ(q.error().fault, RobotFault::Refused);
    EXPECT_THAT(q.error().detail, HasSubstr("software limits"));
    const auto wrong = co_await robot.move({JointVector::Constant(6, NAN)}, soon());
    EXPECT_EQ(wrong.error().fault, RobotFault::Refused);
    const auto few = co_await robot.move({JointVector::Zero(5)}, soon());
    EXPECT_EQ(few.error().fault, RobotFault::Refused);
  });
}

TEST_F(EkiRobot, SaysThatAMoveWasAborted) {
  serve({greet_and_answer({Accepted, Moving, Aborted}, static_cast<int>(eki::AckError::Stopped))});
  run([&](KukaEkiRobot& robot) -> asio::awaitable<void> {
    co_await robot.connect(soon());
    const auto q = co_await robot.move({target()}, soon());
    EXPECT_EQ(q.error().fault, RobotFault::Aborted);
    EXPECT_THAT(q.error().detail, HasSubstr("a stop is active"));
  });
}

TEST_F(EkiRobot, DoesNotBelieveAMoveThatEndedElsewhere) {
  serve({[](std::shared_ptr<Peer> peer) -> asio::awaitable<void> {
    co_await peer->write(text(kHello));
    const eki::ToController message = co_await peer->read();
    eki::Command command = std::get<eki::Command>(message);
    command.axes_rad[3] += 0.01;
    co_await peer->write(text(ack(command, InPosition)));
  }});
  run([&](KukaEkiRobot& robot) -> asio::awaitable<void> {
    co_await robot.connect(soon());
    const auto q = co_await robot.move({target()}, soon());
    EXPECT_EQ(q.error().fault, RobotFault::Aborted);
    EXPECT_THAT(q.error().detail, HasSubstr("away from its target"));
  });
}

TEST_F(EkiRobot, RepeatsALostMoveWithTheSameIdAndAnotherOneWithANewId) {
  std::vector<eki::Command> seen;
  const Script drop = [&](std::shared_ptr<Peer> peer) -> asio::awaitable<void> {
    co_await peer->write(text(kHello));
    const eki::ToController message = co_await peer->read();
    seen.push_back(std::get<eki::Command>(message));
    co_await peer->write(text(ack(seen.back(), Moving)));
    peer->close();
  };
  serve({drop, drop, greet_and_answer({InPosition}, 0, &seen)});
  run([&](KukaEkiRobot& robot) -> asio::awaitable<void> {
    co_await robot.connect(soon());
    const auto lost = co_await robot.move({target()}, soon());
    EXPECT_EQ(lost.error().fault, RobotFault::Disconnected);
    EXPECT_THAT(lost.error().detail, HasSubstr("CellLink at 127.0.0.1:"));
    const auto closed = co_await robot.move({target()}, soon());
    EXPECT_EQ(closed.error().fault, RobotFault::Disconnected);
    co_await robot.connect(soon());
    const auto again = co_await robot.move({target()}, soon());
    EXPECT_EQ(again.error().fault, RobotFault::Disconnected);
    co_await robot.connect(soon());
    const auto other = co_await robot.move({JointVector::Zero(6)}, soon());
    EXPECT_TRUE(other) << other.error().detail;
  });
  ASSERT_EQ(seen.size(), 3u);
  EXPECT_EQ(seen[0], seen[1]);
  EXPECT_GT(seen[2].id, seen[1].id);
}

TEST_F(EkiRobot, TellsRefusedSilentAndNonsenseApart) {
  const Script silent = [](std::shared_ptr<Peer> peer) -> asio::awaitable<void> { co_await peer->read(); };
  const Script nonsense = [](std::shared_ptr<Peer> peer) -> asio::awaitable<void> {
    co_await peer->write("<Hello Ver=\"one\"></Hello>");
    co_await peer->read();
  };
  const Script newer = [](std::shared_ptr<Peer> peer) -> asio::awaitable<void> {
    eki::Hello hello = kHello;
    hello.version = 2;
    co_await peer->write(text(hello));
    co_await peer->read();
  };
  serve({silent, nonsense, newer});
  run([&](KukaEkiRobot& robot) -> asio::awaitable<void> {
    const auto timeout = co_await robot.connect(clock_.now() + 300ms);
    EXPECT_EQ(timeout.error().fault, RobotFault::Timeout);
    EXPECT_THAT(timeout.error().detail, HasSubstr("connected but silent"));
    const auto protocol = co_await robot.connect(soon());
    EXPECT_EQ(protocol.error().fault, RobotFault::Protocol);
    EXPECT_THAT(protocol.error().detail, HasSubstr("Hello: Ver is \"one\""));
    const auto version = co_await robot.connect(soon());
    EXPECT_EQ(version.error().fault, RobotFault::Protocol);
    EXPECT_THAT(version.error().detail, HasSubstr("speak version 2"));
    motion_acceptor_.close();
    const auto refused = co_await robot.connect(soon());
    EXPECT_EQ(refused.error().fault, RobotFault::Unreachable);
    EXPECT_THAT(refused.error().detail, HasSubstr("refused: check that the robot program truepose_motion"));
  });
}

TEST_F(EkiRobot, ReportsASilentMoveAsTimeoutAndWorksAgainAfterConnecting) {
  serve({greet_and_answer({Accepted}), greet_and_answer({InPosition})});
  run([&](KukaEkiRobot& robot) -> asio::awaitable<void> {
    co_await robot.connect(soon());
    const auto silent = co_await robot.move({target()}, very_soon());
    EXPECT_EQ(silent.error().fault, RobotFault::Timeout);
    co_await robot.connect(soon());
    const auto q = co_await robot.move({target()}, soon());
    EXPECT_TRUE(q) << q.error().detail;
  });
}

TEST_F(EkiRobot, StartsTheStreamProgramAndReturnsWhenItRuns) {
  std::vector<eki::Command> seen;
  serve({greet_and_answer({Accepted, Moving}, 0, &seen)});
  run([&](KukaEkiRobot& robot) -> asio::awaitable<void> {
    co_await robot.connect(soon());
    const auto started = co_await robot.start_stream_program(soon());
    EXPECT_TRUE(started) << started.error().detail;
  });
  ASSERT_EQ(seen.size(), 1u);
  EXPECT_EQ(seen[0].type, eki::CommandType::StartRsi);
}

}  // namespace
}  // namespace truepose::drivers
