#include "tools/sim/controller/controller.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <optional>
#include <string>
#include <vector>

#include "core/arm/forward.hpp"
#include "core/math/angles.hpp"
#include "proto/eki/messages.hpp"
#include "tests/tools/sim/controller/demo_controller.hpp"
#include "tests/tools/sim/eki_axes.hpp"
#include "tests/tools/sim/kr210.hpp"
#include "tools/sim/controller/controller_setup.hpp"

namespace truepose::sim {
namespace {

using namespace std::chrono_literals;
using eki::AckState;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using Act = OperatorAct::Kind;

std::vector<AckState> states(const std::vector<eki::Ack>& acks) {
  std::vector<AckState> states;
  for (const eki::Ack& ack : acks) states.push_back(ack.state);
  return states;
}

/// The shipped files on a controller, and a PC that is connected with both channels.
class ControllerTest : public testing::Test {
 protected:
  ControllerTest() {
    controller.advance(1s);
    EXPECT_TRUE(controller.connect("CellLink"));
    EXPECT_TRUE(controller.connect("CellState"));
  }

  static ControllerSetup setup() {
    config::Scenario scenario = demo_cell();
    scenario.stream_path.clear();
    return controller_setup(scenario);
  }

  /// Everything that the controller has sent meanwhile.
  void listen() {
    for (const Controller::Document& document : controller.take_documents()) {
      const auto messages = eki::decode_from_controller(document.text).value();
      for (const eki::FromController& message : messages) {
        if (const auto* ack = std::get_if<eki::Ack>(&message)) acks.push_back(*ack);
        if (const auto* its = std::get_if<eki::State>(&message)) state = *its;
        if (const auto* its = std::get_if<eki::Hello>(&message)) hello = *its;
      }
    }
  }
  void pass(SimTime time) {
    controller.advance(time);
    listen();
  }
  void send(const eki::Command& command) { controller.receive("CellLink", eki::encode(command)); }
  void send(eki::ControlOp op, int value = 0) {
    controller.receive("CellState", eki::encode(eki::Control{.id = 1, .op = op, .value = value}));
    pass(20ms);
  }
  void move(std::int32_t id, const JointVector& q) {
    send({.id = id, .type = eki::CommandType::Ptp, .settle_ms = 200, .axes_rad = axes_of(q)});
  }
  /// One cycle of RSI whose drives follow at once.
  void rsi_cycle(const FlowEffects& effects = {}) {
    static_cast<RsiProgram&>(controller).advance(kRsiCycle, controller.set_points(), kNoCorrection);
    controller.take(effects);
    listen();
  }

  const JointVector target = deg(20, -80, 95, 0, 30, 0);
  Controller controller{setup()};
  std::vector<eki::Ack> acks;
  std::optional<eki::State> state;
  std::optional<eki::Hello> hello;
};

TEST_F(ControllerTest, GreetsWithWhatItsArmIs) {
  listen();
  ASSERT_TRUE(hello);
  EXPECT_EQ(hello->model, "#KR210R2700_2 C4 FLR");
  EXPECT_EQ(hello->serial, "210001");
  EXPECT_EQ(hello->tool, 0);
}

TEST_F(ControllerTest, MovesSettlesAndReportsThePositionItReached) {
  move(1, target);
  pass(10s);
  EXPECT_THAT(states(acks), ElementsAre(AckState::Accepted, AckState::Moving, AckState::InPosition));
  EXPECT_TRUE(joints_of(acks.back().axes_rad.value()).isApprox(target, 1e-6));
  EXPECT_EQ(controller.moves(), 1U);
}

TEST_F(ControllerTest, MovesAtTheProgrammedShareOfItsSpeed) {
  const auto duration = [&](std::int32_t id, const JointVector& to, int percent) {
    acks.clear();
    send({.id = id, .type = eki::CommandType::Ptp, .velocity_percent = percent, .axes_rad = axes_of(to)});
    SimTime time{0};
    for (; acks.empty() || acks.back().state != AckState::InPosition; time += 10ms) pass(10ms);
    return std::chrono::duration<double>(time).count();
  };
  const double fast = duration(1, target, 100), slow = duration(2, target + deg(90, 0, 0, 0, 0, 0), 10);
  EXPECT_LT(fast, 3);
  EXPECT_NEAR(slow, 90 / 11.7, 1.2) << "and half a second of settling";
}

TEST_F(ControllerTest, BrakesWhenTheLinkIsLostAndSaysSoToWhoAsksAgain) {
  move(1, target);
  pass(300ms);
  controller.disconnect("CellLink");
  pass(1s);
  const JointVector stands_at = controller.axes();
  pass(1s);
  EXPECT_EQ(controller.axes(), stands_at);
  ASSERT_TRUE(controller.connect("CellLink"));
  acks.clear();
  move(1, target);
  pass(1s);
  ASSERT_THAT(states(acks), ElementsAre(AckState::Aborted));
  EXPECT_EQ(acks[0].error, static_cast<int>(eki::AckError::LinkLost));
}

TEST_F(ControllerTest, TakesOneClientAndNoneBeforeTheChannelIsOpened) {
  EXPECT_FALSE(controller.connect("CellLink"));
  Controller fresh{setup()};
  EXPECT_FALSE(fresh.connect("CellLink"));
  fresh.advance(1s);
  EXPECT_TRUE(fresh.connect("CellLink"));
}

TEST_F(ControllerTest, StateCarriesAxesAndTheNominalPose) {
  move(1, target);
  pass(10s);
  send(eki::ControlOp::AskState);
  ASSERT_TRUE(state);
  EXPECT_TRUE(joints_of(state->axes_rad).isApprox(target, 1e-6));
  const Eigen::Vector3d p = forward_kinematics(demo_cell().nominal, target).translation();
  EXPECT_NEAR(state->pose[0], p.x(), 1e-2);
  EXPECT_NEAR(state->pose[2], p.z(), 1e-2);
  EXPECT_EQ(state->mode, eki::OperatingMode::Ext);
  EXPECT_EQ(state->program, eki::ProgramState::Active);
  EXPECT_TRUE(state->in_position);
}

TEST_F(ControllerTest, AnEmergencyStopTakesTheDrivesAndTheProgramGoesOnWhenItIsStartedAgain) {
  move(1, target);
  pass(300ms);
  controller.operate({.kind = Act::EmergencyStop});
  const JointVector stopped_at = controller.axes();
  pass(5s);
  EXPECT_EQ(controller.axes(), stopped_at);
  controller.operate({.kind = Act::Start});
  send(eki::ControlOp::AskState);
  EXPECT_FALSE(state->no_emergency_stop);
  EXPECT_FALSE(state->drives_ready);
  EXPECT_FALSE(state->moving) << "without drives the arm stands";
  EXPECT_TRUE(state->gate_closed);
  EXPECT_EQ(state->program, eki::ProgramState::Stopped);
  controller.operate({.kind = Act::ReleaseEmergencyStop});
  pass(5s);
  EXPECT_EQ(controller.axes(), stopped_at) << "nobody has started it";
  controller.operate({.kind = Act::Start});
  pass(10s);
  EXPECT_EQ(acks.back().state, AckState::InPosition);
}

TEST_F(ControllerTest, TheGateStopsItInAutomaticAndNotInT1) {
  controller.operate({.kind = Act::OpenGate});
  send(eki::ControlOp::AskState);
  EXPECT_FALSE(state->gate_closed);
  EXPECT_FALSE(state->drives_ready);
  controller.operate({.kind = Act::CloseGate});
  controller.operate({.kind = Act::SetMode, .number = 1});
  controller.operate({.kind = Act::Start});
  controller.operate({.kind = Act::OpenGate});
  send(eki::ControlOp::AskState);
  EXPECT_TRUE(state->drives_ready);
  EXPECT_EQ(state->mode, eki::OperatingMode::T1);
}

TEST_F(ControllerTest, IsJoggedByHandWhereNoProgramRunsAndTellsWhereItStands) {
  EXPECT_EQ(controller.jog(target).error(), "jog: expected the key at T1 or T2");
  controller.operate({.kind = Act::SetMode, .number = 1});
  controller.operate({.kind = Act::Start});
  EXPECT_EQ(controller.jog(target).error(), "jog: a program runs, stop it first");
  controller.operate({.kind = Act::Stop});
  ASSERT_TRUE(controller.jog(target));
  pass(1s);
  send(eki::ControlOp::AskState);
  EXPECT_TRUE(state->in_position);
  for (std::size_t i = 0; i < 6; ++i)
    EXPECT_NEAR(state->axes_rad[i], target[static_cast<Eigen::Index>(i)], 1e-6) << i;
}

TEST_F(ControllerTest, ACancelledProgramDeletesItsChannelAndTheSubmitProgramStillAnswers) {
  controller.operate({.kind = Act::Deselect});
  EXPECT_THAT(controller.take_closed(), ElementsAre("CellLink"));
  EXPECT_FALSE(controller.connect("CellLink"));
  send(eki::ControlOp::AskState);
  ASSERT_TRUE(state);
  EXPECT_EQ(state->program, eki::ProgramState::Free);
  EXPECT_EQ(state->pose[0], 0) << "without a tool and a base there is no pose";
  EXPECT_THAT(controller.take_messages(), IsEmpty());
}

TEST_F(ControllerTest, OpensRsiOnCommandWhereItStandsAndLeavesByStop) {
  move(1, target);
  pass(10s);
  EXPECT_FALSE(controller.rsi());
  send({.id = 2, .type = eki::CommandType::StartRsi, .axes_rad = {}});
  listen();
  EXPECT_EQ(acks.back().state, AckState::Moving);
  ASSERT_TRUE(controller.rsi());
  EXPECT_EQ(controller.rsi()->context, "truepose_rsi");
  for (int cycle = 0; cycle < 100; ++cycle) rsi_cycle();
  EXPECT_TRUE(controller.set_points().isApprox(target, 1e-6)) << "the arm stands in RSI_MOVECORR";
  rsi_cycle({.leaves_movecorr = true});
  rsi_cycle();
  EXPECT_FALSE(controller.rsi());
  controller.rsi_ended(1, RsiEnd::Off, controller.axes());
  pass(1s);
  EXPECT_EQ(acks.back().state, AckState::InPosition);
}

TEST_F(ControllerTest, ATimeoutOfRsiStopsTheProgramUntilSomebodyStartsItAgain) {
  send({.id = 2, .type = eki::CommandType::StartRsi, .axes_rad = {}});
  rsi_cycle();
  controller.rsi_ended(1, RsiEnd::Timeout, controller.axes());
  EXPECT_FALSE(controller.rsi());
  EXPECT_THAT(controller.take_messages(), ElementsAre(HasSubstr("KSS29002")));
  send(eki::ControlOp::AskState);
  EXPECT_TRUE(state->stop_message);
  EXPECT_EQ(state->program, eki::ProgramState::Stopped);
  controller.operate({.kind = Act::Start});
  pass(1s);
  EXPECT_EQ(acks.back().state, AckState::InPosition);
  move(3, target);
  pass(10s);
  EXPECT_TRUE(controller.axes().isApprox(target, 1e-6));
}

TEST_F(ControllerTest, OverrideSlowsTheMotionThatIsMade) {
  send(eki::ControlOp::SetOverride, 10);
  move(1, target);
  pass(3s);
  EXPECT_EQ(states(acks).back(), AckState::Moving);
  controller.operate({.kind = Act::SetOverride, .number = 100});
  pass(10s);
  EXPECT_EQ(states(acks).back(), AckState::InPosition);
}

TEST_F(ControllerTest, SwitchedOffItAnswersNobodyAndSwitchedOnItServesAgain) {
  controller.operate({.kind = Act::SwitchOff});
  EXPECT_THAT(controller.take_closed(), ElementsAre("CellLink", "CellState"));
  EXPECT_FALSE(controller.connect("CellState"));
  controller.operate({.kind = Act::Start});
  pass(1s);
  EXPECT_FALSE(controller.connect("CellState"));
  controller.operate({.kind = Act::SwitchOn});
  pass(1s);
  EXPECT_TRUE(controller.connect("CellState"));
  EXPECT_TRUE(controller.connect("CellLink"));
  listen();
  EXPECT_TRUE(hello);
}

TEST(Controller, NamesTheLineOfAProgramThatItCannotLoad) {
  ControllerSetup setup = controller_setup(demo_cell());
  setup.programs.push_back({"customer.src", "DEF CUSTOMER()\n  PTP NOWHERE\nEND\n"});
  try {
    const Controller controller{setup};
    ADD_FAILURE() << "loaded";
  } catch (const std::invalid_argument& e) {
    EXPECT_THAT(e.what(), HasSubstr("customer.src:2"));
  }
}

TEST(Controller, NeedsSixAxes) {
  ControllerSetup setup = controller_setup(demo_cell());
  setup.nominal.joints.pop_back();
  EXPECT_THROW(Controller{setup}, std::invalid_argument);
}

}  // namespace
}  // namespace truepose::sim
