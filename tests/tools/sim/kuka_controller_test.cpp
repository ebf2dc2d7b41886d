#include "tools/sim/kuka_controller.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <vector>

#include "core/arm/forward.hpp"
#include "core/math/angles.hpp"
#include "tests/tools/sim/kr210.hpp"

namespace truepose::sim {
namespace {

using eki::AckError;
using eki::AckState;
using eki::CommandType;
using eki::ControlOp;
using std::chrono::milliseconds;
using testing::ElementsAre;
using testing::IsEmpty;
using namespace std::chrono_literals;

const JointVector kHome = deg(0, -90, 90, 0, 35, 0);
const JointVector kTarget = deg(40, -70, 80, 10, 45, -20);

KukaController controller() {
  return KukaController{{.nominal = kr210(),
                         .model = "#KR210R2700_2",
                         .serial = "SIM-0001",
                         .start = kHome,
                         .rsi_start = kHome}};
}

eki::Command ptp(std::int32_t id, const JointVector& q = kTarget) {
  return {
      .id = id, .type = CommandType::Ptp, .velocity_percent = 50, .settle_ms = 500, .axes_rad = to_axes(q)};
}

eki::Command start_rsi(std::int32_t id) { return {.id = id, .type = CommandType::StartRsi, .axes_rad = {}}; }

eki::Control op(ControlOp what, int value = 0) { return {.id = 900, .op = what, .value = value}; }

std::vector<AckState> states(const std::vector<eki::Ack>& acks) {
  std::vector<AckState> states;
  for (const eki::Ack& ack : acks) states.push_back(ack.state);
  return states;
}

TEST(KukaController, MovesSettlesAndReportsThePositionItReached) {
  KukaController kuka = controller();
  EXPECT_THAT(states(kuka.command(ptp(1), 1s)), ElementsAre(AckState::Accepted, AckState::Moving));
  EXPECT_TRUE(kuka.moving(1s + 100ms));
  EXPECT_NE(kuka.axes(1s + 100ms), kHome);

  const SimTime stands = kuka.next_change().value();
  EXPECT_THAT(kuka.advance(stands), IsEmpty()) << "it has not settled yet";
  EXPECT_FALSE(kuka.moving(stands));
  EXPECT_EQ(kuka.next_change().value(), stands + 500ms);
  EXPECT_THAT(kuka.advance(stands + 499ms), IsEmpty());

  const auto acks = kuka.advance(stands + 500ms);
  ASSERT_THAT(states(acks), ElementsAre(AckState::InPosition));
  EXPECT_EQ(acks[0].id, 1);
  EXPECT_EQ(acks[0].axes_rad, to_axes(kTarget));
  EXPECT_EQ(kuka.next_change(), std::nullopt);
}

TEST(KukaController, MovesAtTheProgrammedShareOfItsSpeed) {
  KukaController kuka = controller();
  kuka.command(ptp(1, deg(117, -90, 90, 0, 35, 0)), 0s);  // A1: one second at full speed
  // Half speed takes two; with the default acceleration of 50 % the ramps cost half a second.
  EXPECT_EQ(std::chrono::round<milliseconds>(kuka.next_change().value()), 2500ms);
}

TEST(KukaController, AnswersARepeatedIdWithItsLastWordAndDoesNotMoveAgain) {
  KukaController kuka = controller();
  kuka.command(ptp(7), 0s);
  EXPECT_THAT(states(kuka.command(ptp(7), 100ms)), ElementsAre(AckState::Moving));
  kuka.advance(1min);
  EXPECT_THAT(states(kuka.command(ptp(7, kHome), 1min)), ElementsAre(AckState::InPosition));
  EXPECT_FALSE(kuka.moving(1min));
  EXPECT_EQ(kuka.axes(1min), kTarget);
  EXPECT_EQ(kuka.moves(), 1u);
}

TEST(KukaController, CarriesCommandsOutOneAfterTheOther) {
  KukaController kuka = controller();
  kuka.command(ptp(1), 0s);
  EXPECT_THAT(kuka.command(ptp(2, kHome), 10ms), IsEmpty());
  EXPECT_THAT(kuka.command(ptp(2, kHome), 20ms), IsEmpty()) << "it waits only once";
  const SimTime settled = 1min;
  EXPECT_THAT(states(kuka.advance(settled)),
              ElementsAre(AckState::InPosition, AckState::Accepted, AckState::Moving));
  EXPECT_THAT(states(kuka.advance(2 * settled)), ElementsAre(AckState::InPosition));
  EXPECT_EQ(kuka.axes(2 * settled), kHome);
}

TEST(KukaController, RejectsATargetOutOfRangeWithoutMoving) {
  KukaController kuka = controller();
  std::int32_t id = 0;
  for (const JointVector& q :
       {deg(0, -4.9, 90, 0, 35, 0), deg(186, -90, 90, 0, 35, 0), JointVector{kHome * std::nan("")}}) {
    const auto acks = kuka.command(ptp(++id, q), 0s);
    ASSERT_THAT(states(acks), ElementsAre(AckState::Rejected));
    EXPECT_EQ(acks[0].error, static_cast<int>(AckError::OutOfRange));
    EXPECT_FALSE(kuka.moving(0s));
  }
  EXPECT_EQ(kuka.axes(1s), kHome);
}

TEST(KukaController, StopAbortsTheMotionAndRefusesFurtherOnesUntilReleased) {
  KukaController kuka = controller();
  kuka.command(ptp(1), 0s);
  const auto stopped = kuka.control(op(ControlOp::Stop), 300ms);
  ASSERT_THAT(states(stopped.acks), ElementsAre(AckState::Aborted));
  EXPECT_EQ(stopped.acks[0].error, static_cast<int>(AckError::Stopped));
  EXPECT_TRUE(stopped.state.stop_message);
  EXPECT_FALSE(stopped.state.moving);
  const JointVector braked = kuka.axes(300ms);
  EXPECT_NE(braked, kHome);
  EXPECT_EQ(kuka.axes(10s), braked);

  EXPECT_THAT(states(kuka.command(ptp(2), 11s)), ElementsAre(AckState::Rejected));
  EXPECT_FALSE(kuka.control(op(ControlOp::ReleaseStop), 12s).state.stop_message);
  EXPECT_THAT(states(kuka.command(ptp(3), 13s)), ElementsAre(AckState::Accepted, AckState::Moving));
}

TEST(KukaController, BrakesWhenTheLinkIsLostAndSaysSoWhenAskedAgain) {
  KukaController kuka = controller();
  kuka.command(ptp(1), 0s);
  kuka.link_lost(300ms);
  EXPECT_FALSE(kuka.moving(400ms));
  EXPECT_NE(kuka.axes(400ms), kHome);
  const auto acks = kuka.command(ptp(1), 1s);
  ASSERT_THAT(states(acks), ElementsAre(AckState::Aborted));
  EXPECT_EQ(acks[0].error, static_cast<int>(AckError::LinkLost));
}

TEST(KukaController, DrivesOffEndTheMotionAndTheStateSaysWhy) {
  KukaController kuka = controller();
  kuka.command(ptp(1), 0s);
  EXPECT_THAT(states(kuka.control(op(ControlOp::Drives, 0), 100ms).acks), ElementsAre(AckState::Aborted));
  EXPECT_THAT(states(kuka.command(ptp(2), 200ms)), ElementsAre(AckState::Rejected));
  EXPECT_FALSE(kuka.control(op(ControlOp::AskState), 300ms).state.drives_ready);
}

TEST(KukaController, OverrideSlowsTheNextMotion) {
  KukaController fast = controller(), slow = controller();
  EXPECT_EQ(slow.control(op(ControlOp::SetOverride, 50), 0s).state.override_percent, 50);
  fast.command(ptp(1), 0s);
  slow.command(ptp(1), 0s);
  EXPECT_GT(slow.next_change().value(), fast.next_change().value());
}

TEST(KukaController, StateCarriesAxesAndTheNominalPose) {
  KukaController kuka = controller();
  const eki::State state = kuka.control({.id = 5, .op = ControlOp::AskState}, 1s).state;
  EXPECT_EQ(state.id, 5);
  EXPECT_EQ(state.axes_rad, to_axes(kHome));
  const Eigen::Isometry3d reported = pose_from_kuka({state.pose[0], state.pose[1], state.pose[2]},
                                                    {state.pose[3], state.pose[4], state.pose[5]});
  EXPECT_TRUE(reported.isApprox(forward_kinematics(kr210(), kHome), 1e-12));
  EXPECT_TRUE(state.drives_ready && state.gate_closed && state.no_emergency_stop && state.in_position);
  EXPECT_EQ(kuka.control(op(ControlOp::AskState), 2s).state.sequence, state.sequence + 1);
}

TEST(KukaController, OpensRsiAfterTheMotionToItsStart) {
  KukaController kuka = controller();
  kuka.command(ptp(1), 0s);
  kuka.advance(1min);
  EXPECT_THAT(states(kuka.command(start_rsi(2), 1min)), ElementsAre(AckState::Accepted));
  EXPECT_FALSE(kuka.rsi_speed());
  EXPECT_THAT(states(kuka.advance(2min)), ElementsAre(AckState::Moving));
  EXPECT_EQ(kuka.rsi_speed(), 0.2);

  kuka.rsi_cycle(kTarget, true);
  EXPECT_TRUE(kuka.moving(2min));
  EXPECT_EQ(kuka.axes(2min), kTarget);
  EXPECT_THAT(states(kuka.rsi_ended(RsiEnd::Left, 3min)), ElementsAre(AckState::InPosition));
  EXPECT_FALSE(kuka.rsi_speed());
  EXPECT_EQ(kuka.axes(3min), kTarget);
}

TEST(KukaController, ReportsKss29002WhenRsiTimesOut) {
  KukaController kuka = controller();
  kuka.command(start_rsi(1), 0s);
  kuka.advance(1min);
  const auto acks = kuka.rsi_ended(RsiEnd::Timeout, 2min);
  ASSERT_THAT(states(acks), ElementsAre(AckState::Aborted));
  EXPECT_EQ(acks[0].error, kKss29002);
}

TEST(KukaController, LeavesRsiWhenItIsStoppedOrItsLinkIsLost) {
  KukaController stopped = controller(), lost = controller();
  for (KukaController* kuka : {&stopped, &lost}) {
    kuka->command(start_rsi(1), 0s);
    kuka->advance(1min);
    ASSERT_TRUE(kuka->rsi_speed());
  }
  EXPECT_THAT(states(stopped.control(op(ControlOp::Stop), 2min).acks), ElementsAre(AckState::Aborted));
  lost.link_lost(2min);
  EXPECT_FALSE(stopped.rsi_speed());
  EXPECT_FALSE(lost.rsi_speed());
}

TEST(KukaController, AcknowledgesACommandThatDoesNothing) {
  KukaController kuka = controller();
  EXPECT_THAT(states(kuka.command({.id = 4, .axes_rad = {}}, 0s)), ElementsAre(AckState::InPosition));
  EXPECT_FALSE(kuka.moving(0s));
}

TEST(KukaController, NeedsSixAxes) {
  RobotModel five = kr210();
  five.joints.pop_back();
  EXPECT_THROW(KukaController({.nominal = five, .model = "", .serial = "", .start = {}, .rsi_start = {}}),
               std::invalid_argument);
}

}  // namespace
}  // namespace truepose::sim
