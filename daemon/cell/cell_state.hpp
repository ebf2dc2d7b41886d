#pragma once

#include <array>
#include <chrono>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "daemon/campaign/cell_devices.hpp"
#include "daemon/fault_text.hpp"

namespace truepose::daemon {

/// A device that has to answer before the state continues.
struct Waiting {
  CellDevice device = CellDevice::Controller;
  TimePoint since;
  std::string reason;  ///< what it is waited for to do, or what has happened to it
  bool operator==(const Waiting&) const = default;
};

// States: each holds only what is true in it.
struct Disconnected {
  bool operator==(const Disconnected&) const = default;
};
struct Connecting {
  TimePoint since;
  std::optional<Waiting> waiting{};
  bool operator==(const Connecting&) const = default;
};
struct Ready {
  bool operator==(const Ready&) const = default;
};
struct Running {
  std::string campaign_id;
  std::optional<Waiting> waiting{};
  bool operator==(const Running&) const = default;
};
struct Paused {
  std::string campaign_id;
  std::optional<Waiting> waiting{};
  bool goes_on = false;  ///< by itself, once the device answers that it waits for
  bool operator==(const Paused&) const = default;
};
struct Aborting {
  std::string campaign_id;
  TimePoint since;
  bool operator==(const Aborting&) const = default;
};
struct StreamStarting {
  TimePoint since;
  bool program_runs = false;  ///< and since then
  bool operator==(const StreamStarting&) const = default;
};
struct Streaming {
  std::optional<Waiting> waiting{};
  bool operator==(const Streaming&) const = default;
};
/// Corrections are ramped out.
struct StreamStopping {
  TimePoint since;
  bool operator==(const StreamStopping&) const = default;
};
/// Whatever session the arm's own programs open is corrected, with neither EKI nor tracker.
struct Armed {
  bool operator==(const Armed&) const = default;
};
/// The correction of the session that is open is ramped out, and no other is corrected any more.
struct Disarming {
  TimePoint since;
  bool operator==(const Disarming&) const = default;
};
/// Cleared by an operator's acknowledgement.
struct Faulted {
  std::string reason;  ///< what is wrong, and each step of the way back to what the cell did
  bool operator==(const Faulted&) const = default;
};
using CellState = std::variant<Disconnected, Connecting, Ready, Running, Paused, Aborting, StreamStarting,
                               Streaming, StreamStopping, Armed, Disarming, Faulted>;

/// The name on the wire, as cell.status knows it: "disconnected", "ready", "campaign". An abort under way
/// still is "campaign", a stream that starts or stops "streaming", and one that is being disarmed "armed".
std::string_view state_name(const CellState& state);
/// All of them.
inline constexpr std::array<std::string_view, 8> kStateNames{
    "disconnected", "connecting", "ready", "campaign", "paused", "streaming", "armed", "fault"};

/// Which device the state waits for, and since when; none where it waits for none. Where several have to
/// answer it is the one that was lost first.
std::optional<Waiting> waiting(const CellState& state);

/// What an operator does next, in one sentence.
std::string next_step(const CellState& state);

// Requests of operators.
struct ConnectRequested {};
struct DisconnectRequested {};
struct AcknowledgeRequested {};
struct CampaignStartRequested {
  std::string campaign_id;
};
struct CampaignPauseRequested {};
struct CampaignResumeRequested {
  std::string campaign_id;  ///< of one that was interrupted; empty: of the one that is paused
};
struct CampaignAbortRequested {};
struct StreamStartRequested {};
struct StreamStopRequested {};
struct ArmRequested {};
struct DisarmRequested {};
// What the daemon found out.
struct DevicesConnected {};
struct ConnectFailed {
  FaultText fault;
};
struct DeviceLost {
  FaultText fault;
};
/// What is under way continues once the device answers.
struct DeviceAwaited {
  CellDevice device = CellDevice::Controller;
  std::string reason;  ///< empty: it answers again
};
/// It has paused itself.
struct CampaignPaused {};
struct CampaignEnded {
  /// The devices are; else it did not need both or was aborted before it had them, and they are let go.
  bool connected = true;
};
/// The controller's program runs that opens RSI.
struct StreamProgramStarted {};
struct StreamStarted {};
struct StreamEnded {};
struct StreamFaulted {
  FaultText fault;
};
/// The store could not keep what a campaign has come to.
struct StoreFailed {
  FaultText fault;
};
struct Tick {
  std::string no_packet_answered;  ///< why, where a stream is being started
};
using CellEvent =
    std::variant<ConnectRequested, DisconnectRequested, AcknowledgeRequested, CampaignStartRequested,
                 CampaignPauseRequested, CampaignResumeRequested, CampaignAbortRequested,
                 StreamStartRequested, StreamStopRequested, ArmRequested, DisarmRequested, DevicesConnected,
                 ConnectFailed, DeviceLost, DeviceAwaited, CampaignPaused, CampaignEnded,
                 StreamProgramStarted, StreamStarted, StreamEnded, StreamFaulted, StoreFailed, Tick>;

/// What is done at once. What takes time (opening devices, starting a campaign or a stream) follows the new
/// state, by the service that has asked.
enum class CellCommand {
  CloseDevices,
  PauseCampaign,
  ResumeCampaign,
  AbortCampaign,
  StopStream,
  ArmStream,
  RearmStream,  ///< a stream that holds continues from the correction that it holds
};
inline constexpr std::size_t kCellCommands = 7;

/// How long the states that pass by themselves may last.
struct CellLimits {
  std::chrono::seconds connecting{300};
  std::chrono::seconds aborting{60};
  std::chrono::seconds stream_program{30};
  std::chrono::seconds stream_starting{4};  ///< from the program's start to the first packet that is answered
  std::chrono::seconds stream_stopping{30};
  std::chrono::seconds campaign_waiting{60};  ///< for a device, before the campaign pauses
};

/// Why a request was not carried out.
struct Refusal {
  std::string state;                 ///< name of the state that the cell is in
  std::vector<std::string> allowed;  ///< methods that the state does carry out, e.g. "campaign.start"
  /// "not possible in state campaign; allowed: campaign.pause, campaign.abort"
  std::string sentence() const;
};

/// When Tick is due, because the state, or what it waits for, then has lasted too long; none where it may
/// last for ever.
std::optional<TimePoint> deadline(const CellState& state, const CellLimits& limits = {});

struct CellStep {
  CellState next;
  std::vector<CellCommand> commands;  ///< in this order
  std::optional<Refusal> refused;     ///< requests only; then the state stays and nothing is commanded
};

/// The methods that a state carries out, e.g. "campaign.start".
std::vector<std::string> allowed_methods(const CellState& state);

/// The cell's state machine: a function of state, event and time, and nothing else.
CellStep advance(const CellState& state, const CellEvent& event, TimePoint now,
                 const CellLimits& limits = {});

}  // namespace truepose::daemon
