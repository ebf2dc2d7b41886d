#include "daemon/cell/cell_state.hpp"

#include <gmock/gmock.h>

#include <algorithm>
#include <set>

namespace truepose::daemon {
namespace {

using namespace std::chrono_literals;
using testing::ElementsAre;
using testing::IsEmpty;
using C = CellCommand;

const TimePoint t0{1h};

const std::vector<CellState> kStates{
    Disconnected{},     Connecting{t0},     Ready{},     Running{"c1"},      Paused{"c1"},
    Aborting{"c1", t0}, StreamStarting{t0}, Streaming{}, StreamStopping{t0}, Armed{},
    Disarming{t0},      Faulted{"why"}};

const std::vector<CellEvent> kRequests{ConnectRequested{},       DisconnectRequested{},
                                       AcknowledgeRequested{},   CampaignStartRequested{"c2"},
                                       CampaignPauseRequested{}, CampaignResumeRequested{},
                                       CampaignAbortRequested{}, StreamStartRequested{},
                                       StreamStopRequested{},    ArmRequested{},
                                       DisarmRequested{}};
const std::vector<CellEvent> kOutcomes{DevicesConnected{},
                                       ConnectFailed{{"x"}},
                                       DeviceLost{{"x"}},
                                       CampaignPaused{},
                                       CampaignEnded{},
                                       StreamProgramStarted{},
                                       StreamStarted{},
                                       StreamEnded{},
                                       StreamFaulted{{"x"}},
                                       StoreFailed{{"x"}},
                                       Tick{},
                                       DeviceAwaited{CellDevice::Tracker, "x"}};

/// Where a fault ends that no stream was ended by.
const std::string kConnect = "; then acknowledge the fault and connect";

CellState after(const CellState& state, const CellEvent& event) { return advance(state, event, t0).next; }

TEST(CellState, EveryRequestInEveryStateIsCarriedOutOrRefusedNamingStateAndWhatIsAllowed) {
  ASSERT_EQ(kRequests.size() + kOutcomes.size(), std::variant_size_v<CellEvent>);
  for (const CellState& state : kStates) {
    std::size_t carried_out = 0;
    std::size_t allowed = 0;
    for (const CellEvent& request : kRequests) {
      const CellStep step = advance(state, request, t0);
      if (!step.refused) {
        const bool starts = std::holds_alternative<CampaignStartRequested>(request);
        carried_out += starts ? 2 : 1;  // campaign.start and drift.check
        EXPECT_TRUE(step.next != state || !step.commands.empty())
            << state_name(state) << " request " << request.index();
        continue;
      }
      EXPECT_EQ(step.next, state);
      EXPECT_THAT(step.commands, IsEmpty());
      EXPECT_EQ(step.refused->state, state_name(state));
      EXPECT_THAT(step.refused->sentence(), testing::HasSubstr(std::string{state_name(state)}));
      allowed = step.refused->allowed.size();
    }
    EXPECT_EQ(carried_out, allowed) << state_name(state);
  }
}

TEST(CellState, OutcomesAreNeverRefused) {
  for (const CellState& state : kStates) {
    for (const CellEvent& outcome : kOutcomes) EXPECT_FALSE(advance(state, outcome, t0).refused);
  }
}

TEST(CellState, TheRefusalListsTheMethodsThatAreAllowed) {
  const CellStep step = advance(Running{"c1"}, StreamStartRequested{}, t0);
  ASSERT_TRUE(step.refused);
  EXPECT_THAT(step.refused->allowed, ElementsAre("campaign.pause", "campaign.abort"));
  EXPECT_EQ(step.refused->sentence(),
            "not possible in state campaign; allowed: campaign.pause, campaign.abort");
}

struct Transition {
  CellState from;
  CellEvent event;
  CellState to;
  std::vector<CellCommand> commands;
};

TEST(CellState, FollowsTheTableOfTransitions) {
  const std::vector<Transition> table{
      {Disconnected{}, ConnectRequested{}, Connecting{t0}, {}},
      {Connecting{t0}, DevicesConnected{}, Ready{}, {}},
      {Connecting{t0}, ConnectFailed{{"refused"}}, Faulted{"refused" + kConnect}, {C::CloseDevices}},
      {Connecting{t0}, DisconnectRequested{}, Disconnected{}, {C::CloseDevices}},
      {Ready{}, DisconnectRequested{}, Disconnected{}, {C::CloseDevices}},
      {Ready{}, DeviceLost{{"gone"}}, Faulted{"gone" + kConnect}, {C::CloseDevices}},
      {Ready{}, CampaignStartRequested{"c2"}, Running{"c2"}, {}},
      {Disconnected{}, CampaignStartRequested{"c2"}, Running{"c2"}, {}},
      {Running{"c1"}, CampaignPauseRequested{}, Paused{"c1"}, {C::PauseCampaign}},
      {Paused{"c1"}, CampaignResumeRequested{}, Running{"c1"}, {C::ResumeCampaign}},
      {Paused{"c1"}, CampaignResumeRequested{"c1"}, Running{"c1"}, {C::ResumeCampaign}},
      {Ready{}, CampaignResumeRequested{"c2"}, Running{"c2"}, {}},
      {Disconnected{}, CampaignResumeRequested{"c2"}, Running{"c2"}, {}},
      {Running{"c1"}, CampaignAbortRequested{}, Aborting{"c1", t0}, {C::AbortCampaign}},
      {Paused{"c1"}, CampaignAbortRequested{}, Aborting{"c1", t0}, {C::AbortCampaign}},
      {Aborting{"c1", t0}, CampaignEnded{}, Ready{}, {}},
      {Running{"c1"}, CampaignPaused{}, Paused{"c1"}, {}},
      {Running{"c1"}, CampaignEnded{}, Ready{}, {}},
      {Running{"c1"}, CampaignEnded{.connected = false}, Disconnected{}, {C::CloseDevices}},
      {Paused{"c1"}, CampaignEnded{.connected = false}, Disconnected{}, {C::CloseDevices}},
      {Running{"c1"}, DeviceLost{{"gone"}}, Running{"c1"}, {}},
      {Ready{}, StreamStartRequested{}, StreamStarting{t0}, {}},
      {StreamStarting{t0}, StreamProgramStarted{}, StreamStarting{t0, true}, {}},
      {StreamStarting{t0}, StreamStarted{}, StreamStarting{t0}, {}},
      {StreamStarting{t0, true}, StreamStarted{}, Streaming{}, {}},
      {Streaming{}, StreamStopRequested{}, StreamStopping{t0}, {C::StopStream}},
      {StreamStopping{t0}, StreamEnded{}, Ready{}, {}},
      {Streaming{}, StreamEnded{}, Ready{}, {}},
      {Streaming{},
       StreamFaulted{{"bound"}},
       Faulted{"bound; then acknowledge the fault, connect and start the stream"},
       {C::StopStream, C::CloseDevices}},
      {Faulted{"why"}, AcknowledgeRequested{}, Disconnected{}, {C::RearmStream}},
      {Streaming{}, AcknowledgeRequested{}, Streaming{}, {C::RearmStream}},
      {StreamStopping{t0}, AcknowledgeRequested{}, StreamStopping{t0}, {C::RearmStream}},
      {Disconnected{}, ArmRequested{}, Armed{}, {C::ArmStream}},
      {Ready{}, ArmRequested{}, Armed{}, {C::CloseDevices, C::ArmStream}},
      {Armed{}, DisarmRequested{}, Disarming{t0}, {C::StopStream}},
      {Armed{}, StreamEnded{}, Armed{}, {}},
      {Armed{}, DeviceLost{{"gone"}}, Armed{}, {}},
      {Armed{}, AcknowledgeRequested{}, Armed{}, {C::RearmStream}},
      {Armed{},
       StreamFaulted{{"bound"}},
       Faulted{"bound; then acknowledge the fault and arm the stream"},
       {C::StopStream, C::CloseDevices}},
      {Disarming{t0}, StreamEnded{}, Disconnected{}, {C::CloseDevices}},
      {Running{"c1"}, StoreFailed{{"disk full"}}, Faulted{"disk full" + kConnect}, {C::CloseDevices}},
      {Armed{}, StoreFailed{{"disk full"}}, Armed{}, {}},
      {Streaming{}, StoreFailed{{"disk full"}}, Streaming{}, {}},
      {Ready{}, StoreFailed{{"disk full"}}, Ready{}, {}},
  };
  for (const Transition& row : table) {
    const CellStep step = advance(row.from, row.event, t0);
    EXPECT_EQ(step.next, row.to) << state_name(row.from) << " event " << row.event.index();
    EXPECT_EQ(step.commands, row.commands) << state_name(row.from) << " event " << row.event.index();
  }
}

TEST(CellState, EveryWayIntoAFaultSaysEachStepOfTheWayOutOnce) {
  const FaultText why{"robot: it is gone", "look at its cable"};
  std::size_t ways = 0;
  for (const CellState& state : kStates) {
    if (std::holds_alternative<Faulted>(state)) continue;
    std::vector<CellEvent> events{ConnectFailed{why}, DeviceLost{why}, StreamFaulted{why}, StoreFailed{why},
                                  Tick{"no datagram came; look where it goes"}};
    for (const CellEvent& event : events) {
      const CellState next = advance(state, event, t0 + 1h).next;
      const auto* const faulted = std::get_if<Faulted>(&next);
      if (!faulted) continue;
      ++ways;
      const std::string& text = faulted->reason;
      EXPECT_THAT(text, testing::ContainsRegex("; (look|end) .*then acknowledge the fault"));
      EXPECT_EQ(text.find("acknowledge"), text.rfind("acknowledge")) << text;
      EXPECT_EQ(text.find("cable"), text.rfind("cable")) << text;
      // The steps are allowed, one after the other.
      CellState on = after(next, AcknowledgeRequested{});
      if (text.contains("arm the stream")) on = after(on, ArmRequested{});
      if (text.contains("connect")) on = after(after(on, ConnectRequested{}), DevicesConnected{});
      if (text.contains("start the stream")) on = after(on, StreamStartRequested{});
      const bool back_in_stream =
          std::holds_alternative<StreamStarting>(on) || std::holds_alternative<Armed>(on);
      EXPECT_EQ(back_in_stream, text.ends_with("the stream")) << text;
      EXPECT_TRUE(back_in_stream || std::holds_alternative<Ready>(on)) << text;
    }
  }
  EXPECT_GT(ways, 12U);
}

TEST(CellState, AnOutcomeThatComesLateChangesNothing) {
  EXPECT_EQ(after(Disconnected{}, DevicesConnected{}), CellState{Disconnected{}});
  EXPECT_EQ(after(Faulted{"why"}, CampaignEnded{}), (CellState{Faulted{"why"}}));
  EXPECT_EQ(after(Ready{}, StreamEnded{}), CellState{Ready{}});
}

TEST(CellState, StatesThatPassByThemselvesFaultWhenTheyDoNot) {
  const CellLimits limits;
  EXPECT_EQ(advance(Connecting{t0}, Tick{}, t0 + limits.connecting - 1ms, limits).next,
            CellState{Connecting{t0}});
  for (const CellState& state : {CellState{Connecting{t0}}, CellState{Aborting{"c1", t0}},
                                 CellState{StreamStarting{t0}}, CellState{StreamStopping{t0}}}) {
    const CellStep step = advance(state, Tick{}, t0 + 1h, limits);
    EXPECT_TRUE(std::holds_alternative<Faulted>(step.next)) << state_name(state);
    EXPECT_FALSE(step.commands.empty());
  }
  EXPECT_EQ(advance(Streaming{}, Tick{}, t0 + 1000h, limits).next, CellState{Streaming{}});
  EXPECT_EQ(advance(Armed{}, Tick{}, t0 + 1000h, limits).next, CellState{Armed{}});
}

TEST(CellState, SaysWhichDeviceItWaitsForAndSinceWhen) {
  const Waiting controller{CellDevice::Controller, t0, "it has to connect"};
  const Waiting tracker{CellDevice::Tracker, t0, "it restarted"};
  EXPECT_EQ(waiting(Connecting{t0}), controller);
  EXPECT_EQ(waiting(after(Connecting{t0}, DeviceAwaited{CellDevice::Tracker, "it restarted"})), tracker);
  EXPECT_EQ(waiting(StreamStarting{t0})->device, CellDevice::Controller);
  for (const CellState& state : {CellState{Running{"c1"}}, CellState{Paused{"c1"}}, CellState{Streaming{}}}) {
    EXPECT_FALSE(waiting(state)) << state_name(state);
    const CellState held_up = after(state, DeviceAwaited{CellDevice::Tracker, "it restarted"});
    EXPECT_EQ(waiting(held_up), tracker) << state_name(state);
    const CellState later =
        advance(held_up, DeviceAwaited{CellDevice::Tracker, "it does not answer"}, t0 + 1min).next;
    EXPECT_EQ(waiting(later)->since, t0) << "as long as it is the same";
    EXPECT_EQ(waiting(later)->reason, "it does not answer");
    EXPECT_TRUE(waiting(after(later, DeviceAwaited{CellDevice::Controller, ""}))) << "another one answers";
    EXPECT_EQ(after(later, DeviceAwaited{CellDevice::Tracker, ""}), state);
  }
  const CellState both = after(Running{"c1", tracker}, DeviceAwaited{CellDevice::Controller, "gone too"});
  EXPECT_EQ(waiting(both), tracker) << "the one that was lost first";
  const CellState held_up = Running{"c1", tracker};
  EXPECT_EQ(waiting(after(held_up, CampaignPauseRequested{})), tracker) << "a pause does not bring it back";
  EXPECT_FALSE(waiting(after(held_up, CampaignEnded{})));
  EXPECT_EQ(after(Ready{}, DeviceAwaited{CellDevice::Tracker, "x"}), CellState{Ready{}});
}

TEST(CellState, ACampaignPausesByItselfWhereADeviceStaysAwayAndGoesOnOnceThatAnswers) {
  const CellLimits limits{.campaign_waiting = 60s};
  const Waiting tracker{CellDevice::Tracker, t0, "it restarted"};
  const CellState waits = Running{"c1", tracker};
  EXPECT_EQ(deadline(waits, limits), t0 + 60s);
  EXPECT_EQ(deadline(Running{"c1"}, limits), std::nullopt);
  EXPECT_EQ(advance(waits, Tick{}, t0 + 60s - 1ns, limits).next, waits);
  const CellStep paused = advance(waits, Tick{}, t0 + 60s, limits);
  EXPECT_EQ(paused.next, (CellState{Paused{"c1", tracker, true}}));
  EXPECT_THAT(paused.commands, ElementsAre(C::PauseCampaign));

  const CellStep other = advance(paused.next, DeviceAwaited{CellDevice::Controller, ""}, t0 + 2min);
  EXPECT_EQ(other.next, paused.next) << "it is not the controller that is missed";
  const CellStep back = advance(paused.next, DeviceAwaited{CellDevice::Tracker, ""}, t0 + 2min);
  EXPECT_EQ(back.next, CellState{Running{"c1"}});
  EXPECT_THAT(back.commands, ElementsAre(C::ResumeCampaign));
}

TEST(CellState, ACampaignThatSomebodyPausedWaitsForThatPersonEvenWhereADeviceWasLostMeanwhile) {
  const CellState paused = after(Paused{"c1"}, DeviceAwaited{CellDevice::Tracker, "it restarted"});
  const CellStep back = advance(paused, DeviceAwaited{CellDevice::Tracker, ""}, t0);
  EXPECT_EQ(back.next, CellState{Paused{"c1"}});
  EXPECT_THAT(back.commands, IsEmpty());
}

TEST(CellState, ResumedByAPersonItWaitsAsLongAgainForADeviceThatIsStillAway) {
  const CellState paused = Paused{"c1", Waiting{CellDevice::Tracker, t0, "it restarted"}, true};
  const CellStep resumed = advance(paused, CampaignResumeRequested{}, t0 + 1h);
  EXPECT_EQ(waiting(resumed.next)->since, t0 + 1h);
  EXPECT_THAT(resumed.commands, ElementsAre(C::ResumeCampaign));
}

TEST(CellState, NamesTheMomentAtWhichAStateHasLastedTooLong) {
  const CellLimits limits;
  EXPECT_EQ(deadline(Connecting{t0}), t0 + limits.connecting);
  EXPECT_EQ(deadline(StreamStarting{t0}), t0 + limits.stream_program);
  EXPECT_EQ(deadline(StreamStarting{t0, true}), t0 + limits.stream_starting);
  for (const CellState& state : kStates) {
    const auto due = deadline(state);
    if (!due) continue;
    EXPECT_EQ(advance(state, Tick{}, *due - 1ns).next, state);
    EXPECT_TRUE(std::holds_alternative<Faulted>(advance(state, Tick{}, *due).next)) << state_name(state);
  }
}

TEST(CellState, EveryStateIsReachedFromDisconnected) {
  std::set<std::size_t> seen{CellState{Disconnected{}}.index()};
  std::vector<CellState> open{Disconnected{}}, known = open;
  while (!open.empty()) {
    const CellState state = open.back();
    open.pop_back();
    for (const auto* events : {&kRequests, &kOutcomes}) {
      for (const CellEvent& event : *events) {
        const CellState next = after(state, event);
        seen.insert(next.index());
        if (std::ranges::find(known, next) != known.end()) continue;
        known.push_back(next);
        open.push_back(next);
      }
    }
  }
  EXPECT_EQ(seen.size(), std::variant_size_v<CellState>);
}

}  // namespace
}  // namespace truepose::daemon
