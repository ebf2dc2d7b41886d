#include "daemon/cell/cell_state.hpp"

#include <algorithm>
#include <array>
#include <type_traits>
#include <utility>

namespace truepose::daemon {

namespace {

template <class... Fs>
struct Overloaded : Fs... {
  using Fs::operator()...;
};

/// What an operator may ask for, under the method's name.
const std::array<std::pair<std::string_view, CellEvent>, 12> kRequests{{
    {"cell.connect", ConnectRequested{}},
    {"cell.disconnect", DisconnectRequested{}},
    {"cell.acknowledge", AcknowledgeRequested{}},
    {"campaign.start", CampaignStartRequested{}},
    {"campaign.pause", CampaignPauseRequested{}},
    {"campaign.resume", CampaignResumeRequested{}},
    {"campaign.abort", CampaignAbortRequested{}},
    {"drift.check", CampaignStartRequested{}},
    {"stream.start", StreamStartRequested{}},
    {"stream.stop", StreamStopRequested{}},
    {"stream.arm", ArmRequested{}},
    {"stream.disarm", DisarmRequested{}},
}};

bool is_request(const CellEvent& event) {
  return std::any_of(kRequests.begin(), kRequests.end(),
                     [&](const auto& request) { return request.second.index() == event.index(); });
}

CellStep go(CellState next, std::vector<CellCommand> commands = {}) {
  return {std::move(next), std::move(commands), std::nullopt};
}

/// States that a device can hold up.
template <typename State>
concept HeldUp = requires(State state) {
  state.waiting;
};

template <HeldUp State>
CellStep held_up(State state, const DeviceAwaited& by, TimePoint now) {
  if (!state.waiting && !by.reason.empty()) {
    state.waiting = Waiting{by.device, now, by.reason};
  } else if (state.waiting && state.waiting->device == by.device) {
    state.waiting->reason = by.reason;
    if (by.reason.empty()) state.waiting.reset();
  }
  return go(std::move(state));
}

CellStep held_up(const Paused& paused, const DeviceAwaited& by, TimePoint now) {
  CellStep step = held_up<Paused>(paused, by, now);
  if (!paused.goes_on || waiting(step.next)) return step;
  return go(Running{paused.campaign_id}, {CellCommand::ResumeCampaign});
}

/// Its timeout starts again.
Running resumed(const Paused& paused, TimePoint now) {
  Running running{paused.campaign_id, paused.waiting};
  if (running.waiting) running.waiting->since = now;
  return running;
}

/// As it is started.
std::optional<CellStep> resume_interrupted(const CampaignResumeRequested& resume) {
  if (resume.campaign_id.empty()) return std::nullopt;
  return go(Running{resume.campaign_id});
}

CellStep ended(const CampaignEnded& campaign) {
  return campaign.connected ? go(Ready{}) : go(Disconnected{}, {CellCommand::CloseDevices});
}

/// What follows once the cause of a fault is gone.
template <typename State>
const char* way_back(const State&) {
  if constexpr (std::is_same_v<State, StreamStarting> || std::is_same_v<State, Streaming>)
    return "acknowledge the fault, connect and start the stream";
  if constexpr (std::is_same_v<State, Armed>) return "acknowledge the fault and arm the stream";
  return "acknowledge the fault and connect";
}

/// The one way into that state, which is why each of its texts ends with the way out of it.
template <typename State>
CellStep fault(const State& from, const FaultText& text, std::vector<CellCommand> commands) {
  return go(Faulted{sentence(text, way_back(from))}, std::move(commands));
}

/// What each state does with the requests that it carries out; the others are refused.
std::optional<CellStep> carry_out(const CellState& state, const CellEvent& event, TimePoint now) {
  using C = CellCommand;
  using Maybe = std::optional<CellStep>;
  return std::visit(
      Overloaded{
          [&](const Disconnected&, const ConnectRequested&) -> Maybe { return go(Connecting{now}); },
          [&](const Disconnected&, const CampaignStartRequested& start) -> Maybe {
            return go(Running{start.campaign_id});
          },
          [&](const Disconnected&, const CampaignResumeRequested& resume) -> Maybe {
            return resume_interrupted(resume);
          },
          [&](const Disconnected&, const ArmRequested&) -> Maybe { return go(Armed{}, {C::ArmStream}); },
          [&](const Connecting&, const DisconnectRequested&) -> Maybe {
            return go(Disconnected{}, {C::CloseDevices});
          },
          [&](const Ready&, const DisconnectRequested&) -> Maybe {
            return go(Disconnected{}, {C::CloseDevices});
          },
          [&](const Ready&, const CampaignStartRequested& start) -> Maybe {
            return go(Running{start.campaign_id});
          },
          [&](const Ready&, const CampaignResumeRequested& resume) -> Maybe {
            return resume_interrupted(resume);
          },
          [&](const Ready&, const StreamStartRequested&) -> Maybe { return go(StreamStarting{now}); },
          // The controller runs one program: while another is corrected, no program listens to EKI.
          [&](const Ready&, const ArmRequested&) -> Maybe {
            return go(Armed{}, {C::CloseDevices, C::ArmStream});
          },
          [&](const Running& running, const CampaignPauseRequested&) -> Maybe {
            return go(Paused{running.campaign_id, running.waiting}, {C::PauseCampaign});
          },
          [&](const Running& running, const CampaignAbortRequested&) -> Maybe {
            return go(Aborting{running.campaign_id, now}, {C::AbortCampaign});
          },
          [&](const Paused& paused, const CampaignResumeRequested& resume) -> Maybe {
            if (!resume.campaign_id.empty() && resume.campaign_id != paused.campaign_id) return std::nullopt;
            return go(resumed(paused, now), {C::ResumeCampaign});
          },
          [&](const Paused& paused, const CampaignAbortRequested&) -> Maybe {
            return go(Aborting{paused.campaign_id, now}, {C::AbortCampaign});
          },
          [&](const StreamStarting&, const StreamStopRequested&) -> Maybe {
            return go(StreamStopping{now}, {C::StopStream});
          },
          [&](const Streaming&, const StreamStopRequested&) -> Maybe {
            return go(StreamStopping{now}, {C::StopStream});
          },
          [&](const Armed&, const DisarmRequested&) -> Maybe { return go(Disarming{now}, {C::StopStream}); },
          [&](const Faulted&, const AcknowledgeRequested&) -> Maybe {
            return go(Disconnected{}, {C::RearmStream});
          },
          // A stream whose arm stood still is frozen, which is no fault of the cell.
          [&](const Streaming& s, const AcknowledgeRequested&) -> Maybe { return go(s, {C::RearmStream}); },
          [&](const StreamStopping& s, const AcknowledgeRequested&) -> Maybe {
            return go(s, {C::RearmStream});
          },
          [&](const Armed& s, const AcknowledgeRequested&) -> Maybe { return go(s, {C::RearmStream}); },
          [&](const Disarming& s, const AcknowledgeRequested&) -> Maybe { return go(s, {C::RearmStream}); },
          [](const auto&, const auto&) -> Maybe { return std::nullopt; },
      },
      state, event);
}

std::string seconds(std::chrono::seconds time) { return std::to_string(time.count()) + " s"; }

FaultText not_ramped_out(const CellLimits& limits) {
  return {"the correction was not ramped out in " + seconds(limits.stream_stopping),
          "end the robot program on the pendant"};
}

/// States that pass by themselves, when they do not, and what is waited for in vain.
CellStep on_tick(const CellState& state, const Tick& tick, TimePoint now, const CellLimits& limits) {
  using C = CellCommand;
  const auto due = deadline(state, limits);
  if (!due || now < *due) return go(state);
  return std::visit(
      Overloaded{
          [&](const Connecting& s) {
            const FaultText text{"robot and tracker did not connect in " + seconds(limits.connecting),
                                 "look at both and at their cables"};
            return fault(s, text, {C::CloseDevices});
          },
          [](const Running& s) {
            return go(Paused{s.campaign_id, s.waiting, true}, {C::PauseCampaign});
          },
          [&](const Aborting& s) {
            const FaultText text{
                "the campaign did not end in " + seconds(limits.aborting) + " after its abort",
                "look whether the arm stands, and at robot and tracker"};
            return fault(s, text, {C::CloseDevices});
          },
          [&](const StreamStarting& s) {
            return fault(s, {"no RSI packet could be answered: " + tick.no_packet_answered},
                         {C::StopStream, C::CloseDevices});
          },
          [&](const StreamStopping& s) { return fault(s, not_ramped_out(limits), {C::CloseDevices}); },
          [&](const Disarming& s) { return fault(s, not_ramped_out(limits), {C::CloseDevices}); },
          [](const auto& s) { return go(s); },
      },
      state);
}

/// What the daemon found out. An outcome of something that was given up meanwhile changes nothing.
CellStep on_outcome(const CellState& state, const CellEvent& event, TimePoint now) {
  using C = CellCommand;
  return std::visit(
      Overloaded{
          // What continues without the store does.
          [](const Running& s, const StoreFailed& e) { return fault(s, e.fault, {C::CloseDevices}); },
          [](const Paused& s, const StoreFailed& e) { return fault(s, e.fault, {C::CloseDevices}); },
          [](const Aborting& s, const StoreFailed& e) { return fault(s, e.fault, {C::CloseDevices}); },

          [](const Connecting&, const DevicesConnected&) { return go(Ready{}); },
          [](const Connecting& s, const ConnectFailed& e) { return fault(s, e.fault, {C::CloseDevices}); },
          // A campaign deals with lost devices itself and says so when it cannot.
          [](const Ready& s, const DeviceLost& e) { return fault(s, e.fault, {C::CloseDevices}); },
          [](const StreamStarting& s, const DeviceLost& e) {
            return fault(s, e.fault, {C::StopStream, C::CloseDevices});
          },
          [](const Streaming& s, const DeviceLost& e) {
            return fault(s, e.fault, {C::StopStream, C::CloseDevices});
          },

          [&]<HeldUp State>(const State& s, const DeviceAwaited& e) { return held_up(s, e, now); },

          [](const Running& s, const CampaignPaused&) {
            return go(Paused{s.campaign_id, s.waiting});
          },
          [](const Running&, const CampaignEnded& e) { return ended(e); },
          [](const Paused&, const CampaignEnded& e) { return ended(e); },
          [](const Aborting&, const CampaignEnded& e) { return ended(e); },

          [&](const StreamStarting&, const StreamProgramStarted&) {
            return go(StreamStarting{now, true});
          },
          // Packets that came before are of a program that was running already.
          [](const StreamStarting& s, const StreamStarted&) {
            return s.program_runs ? go(Streaming{}) : go(s);
          },
          [](const StreamStarting&, const StreamEnded&) { return go(Ready{}); },
          [](const Streaming&, const StreamEnded&) { return go(Ready{}); },
          [](const StreamStopping&, const StreamEnded&) { return go(Ready{}); },
          [](const StreamStarting& s, const StreamFaulted& e) {
            return fault(s, e.fault, {C::StopStream, C::CloseDevices});
          },
          [](const Streaming& s, const StreamFaulted& e) {
            return fault(s, e.fault, {C::StopStream, C::CloseDevices});
          },
          [](const StreamStopping& s, const StreamFaulted& e) {
            return fault(s, e.fault, {C::CloseDevices});
          },
          [](const Disarming&, const StreamEnded&) { return go(Disconnected{}, {C::CloseDevices}); },
          [](const Armed& s, const StreamFaulted& e) {
            return fault(s, e.fault, {C::StopStream, C::CloseDevices});
          },
          [](const Disarming& s, const StreamFaulted& e) { return fault(s, e.fault, {C::CloseDevices}); },

          [](const auto& s, const auto&) { return go(s); },
      },
      state, event);
}

}  // namespace

std::string_view state_name(const CellState& state) {
  return std::visit(Overloaded{
                        [](const Disconnected&) { return std::string_view{"disconnected"}; },
                        [](const Connecting&) { return std::string_view{"connecting"}; },
                        [](const Ready&) { return std::string_view{"ready"}; },
                        [](const Running&) { return std::string_view{"campaign"}; },
                        [](const Paused&) { return std::string_view{"paused"}; },
                        [](const Aborting&) { return std::string_view{"campaign"}; },
                        [](const StreamStarting&) { return std::string_view{"streaming"}; },
                        [](const Streaming&) { return std::string_view{"streaming"}; },
                        [](const StreamStopping&) { return std::string_view{"streaming"}; },
                        [](const Armed&) { return std::string_view{"armed"}; },
                        [](const Disarming&) { return std::string_view{"armed"}; },
                        [](const Faulted&) { return std::string_view{"fault"}; },
                    },
                    state);
}

std::string next_step(const CellState& state) {
  constexpr const char* kRampedOut = "Wait until the correction is ramped out.";
  const char* const step = std::visit(
      Overloaded{
          [](const Disconnected&) {
            return "Connect robot and tracker, or start a campaign, which connects them.";
          },
          [](const Connecting&) { return "Wait until robot and tracker answer."; },
          [](const Ready&) { return "Start a campaign, or with an active model the stream."; },
          [](const Running& s) {
            return s.waiting ? "Wait, or remove the cause: the campaign resumes once the device answers."
                             : "Keep out of the cell: the arm moves by itself.";
          },
          [](const Paused& s) {
            return s.goes_on ? "Remove the cause: the campaign resumes once the device answers. Or abort it."
                             : "Do what the state says, then resume the campaign, or abort it.";
          },
          [](const Aborting&) { return "Wait until the campaign has ended."; },
          [](const StreamStarting&) { return "Wait until the controller's packets are answered."; },
          [](const Streaming& s) {
            return s.waiting ? "Wait, or remove the cause: the stream resumes once packets come."
                             : "Keep out of the cell: the robot program runs, and is corrected.";
          },
          [&](const StreamStopping&) { return kRampedOut; },
          [](const Armed&) { return "Start a program on the controller: what opens RSI is corrected."; },
          [&](const Disarming&) { return kRampedOut; },
          [](const Faulted&) { return "Follow the steps of the fault, one after the other."; },
      },
      state);
  return step;
}

std::optional<Waiting> waiting(const CellState& state) {
  using Maybe = std::optional<Waiting>;
  return std::visit(
      Overloaded{
          [](const Connecting& s) -> Maybe {
            return s.waiting ? s.waiting : Waiting{CellDevice::Controller, s.since, "it has to connect"};
          },
          [](const StreamStarting& s) -> Maybe {
            return Waiting{CellDevice::Controller, s.since,
                           s.program_runs ? "its RSI packets have to come" : "its RSI program has to start"};
          },
          []<HeldUp State>(const State& s) -> Maybe { return s.waiting; },
          [](const auto&) -> Maybe { return std::nullopt; },
      },
      state);
}

std::optional<TimePoint> deadline(const CellState& state, const CellLimits& limits) {
  using Maybe = std::optional<TimePoint>;
  return std::visit(Overloaded{
                        [&](const Connecting& s) -> Maybe { return s.since + limits.connecting; },
                        [&](const Running& s) -> Maybe {
                          if (!s.waiting) return std::nullopt;
                          return s.waiting->since + limits.campaign_waiting;
                        },
                        [&](const Aborting& s) -> Maybe { return s.since + limits.aborting; },
                        [&](const StreamStarting& s) -> Maybe {
                          return s.since + (s.program_runs ? limits.stream_starting : limits.stream_program);
                        },
                        [&](const StreamStopping& s) -> Maybe { return s.since + limits.stream_stopping; },
                        [&](const Disarming& s) -> Maybe { return s.since + limits.stream_stopping; },
                        [](const auto&) -> Maybe { return std::nullopt; },
                    },
                    state);
}

std::vector<std::string> allowed_methods(const CellState& state) {
  std::vector<std::string> allowed;
  for (const auto& [method, request] : kRequests) {
    if (carry_out(state, request, TimePoint{})) allowed.emplace_back(method);
  }
  return allowed;
}

std::string Refusal::sentence() const {
  std::string text = "not possible in state " + state;
  if (allowed.empty()) return text + "; nothing is, until that ends";
  text += "; allowed: ";
  for (std::size_t i = 0; i < allowed.size(); ++i) text += (i == 0 ? "" : ", ") + allowed[i];
  return text;
}

CellStep advance(const CellState& state, const CellEvent& event, TimePoint now, const CellLimits& limits) {
  if (is_request(event)) {
    if (auto step = carry_out(state, event, now)) return *std::move(step);
    return {state, {}, Refusal{std::string{state_name(state)}, allowed_methods(state)}};
  }
  if (const auto* tick = std::get_if<Tick>(&event)) return on_tick(state, *tick, now, limits);
  return on_outcome(state, event, now);
}

}  // namespace truepose::daemon
