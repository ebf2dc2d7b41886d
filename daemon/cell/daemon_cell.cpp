#include "daemon/cell/daemon_cell.hpp"

#include <algorithm>
#include <boost/asio/co_spawn.hpp>
#include <boost/asio/experimental/awaitable_operators.hpp>
#include <utility>

#include "daemon/cell/campaign_run.hpp"
#include "daemon/cell/cell_json.hpp"
#include "daemon/log/log.hpp"
#include "proto/control/json_text.hpp"
#include "proto/control/param_reader.hpp"
#include "proto/record/arm_document.hpp"

namespace truepose::daemon {

namespace asio = boost::asio;
namespace json = boost::json;
using control::ErrorCode;
using control::RpcError;
using namespace std::chrono_literals;

namespace {

constexpr Duration kWatch = 50ms;  // a silent controller is told within half a second of its last packet
constexpr Duration kTellStream = 1s;
constexpr Duration kAskDevices = 1s;
constexpr Duration kAskTracker = 5s;
constexpr Duration kUnproven = 1s;  // a session that begins shows within some cycles that nothing is in force
constexpr Duration kDeviceAnswer = 5s;
constexpr Duration kStartProgram = 20s;

std::optional<RpcError> no_parameters(const json::object& params) {
  control::ParamReader read{params};
  return read.finish();
}

Fault cell_fault(const std::string& reason, const std::string& since) {
  return {"E_CELL", "error", reason, since};
}

}  // namespace

DaemonCell::DaemonCell(Parts parts)
    : parts_{std::move(parts)},
      devices_{parts_.config,
               {parts_.robot, parts_.tracker, parts_.clock},
               [this](const std::string& sentence) { on_trouble(sentence); }},
      state_since_{control::rfc3339(parts_.wall_clock())} {}

DaemonCell::~DaemonCell() = default;

const std::vector<DaemonCell::Method>& DaemonCell::table() {
  static const std::vector<Method> methods{{"system.config", &DaemonCell::system_config},
                                           {"cell.status", &DaemonCell::cell_status},
                                           {"cell.connect", &DaemonCell::cell_connect},
                                           {"cell.disconnect", &DaemonCell::cell_disconnect},
                                           {"cell.acknowledge", &DaemonCell::cell_acknowledge},
                                           {"campaign.start", &DaemonCell::campaign_start},
                                           {"drift.check", &DaemonCell::drift_check},
                                           {"campaign.pause", &DaemonCell::campaign_pause},
                                           {"campaign.resume", &DaemonCell::campaign_resume},
                                           {"campaign.abort", &DaemonCell::campaign_abort},
                                           {"campaign.list", &DaemonCell::campaign_list},
                                           {"campaign.get", &DaemonCell::campaign_get},
                                           {"report.get", &DaemonCell::report_get},
                                           {"model.list", &DaemonCell::model_list},
                                           {"model.get", &DaemonCell::model_get},
                                           {"model.activate", &DaemonCell::model_activate},
                                           {"model.deactivate", &DaemonCell::model_deactivate},
                                           {"model.export", &DaemonCell::model_export},
                                           {"targets.compensate", &DaemonCell::targets_compensate},
                                           {"stream.start", &DaemonCell::stream_start},
                                           {"stream.stop", &DaemonCell::stream_stop},
                                           {"stream.status", &DaemonCell::stream_status}};
  return methods;
}

std::vector<std::string> DaemonCell::method_names() {
  std::vector<std::string> names;
  for (const Method& method : table()) names.emplace_back(method.name);
  return names;
}

DaemonCell::Reply DaemonCell::call(std::string method, json::object params) {
  for (const Method& known : table()) {
    if (method != known.name) continue;
    const Handler handler = known.handler;
    Result result = co_await (this->*handler)(std::move(params));
    co_return result;
  }
  co_return std::unexpected(RpcError{ErrorCode::MethodNotFound, "no such method: " + method});
}

std::optional<RpcError> DaemonCell::apply(const CellEvent& event, const std::string& reason) {
  CellStep step = advance(state_, event, parts_.clock.now());
  if (step.refused) {
    return RpcError{
        ErrorCode::WrongState, step.refused->sentence(), {}, step.refused->state, step.refused->allowed};
  }
  const bool was_streaming = streaming();
  const CellState before = std::exchange(state_, std::move(step.next));
  for (const CellCommand command : step.commands) {
    switch (command) {
      case CellCommand::CloseDevices:
        devices_.disconnect();
        identities_.reset();
        robot_state_.reset();
        stand(tracker_lost_, false, {});
        break;
      case CellCommand::PauseCampaign:
        campaign_->campaign.pause();
        break;
      case CellCommand::ResumeCampaign:
        campaign_->campaign.resume();
        break;
      case CellCommand::AbortCampaign:
        campaign_->campaign.abort(reason);
        break;
      case CellCommand::StopStream:
        parts_.stream.disengage();
        break;
      case CellCommand::RearmStream:
        parts_.stream.acknowledge();
        break;
      // Those that take time are carried out by the one who asked.
      case CellCommand::OpenDevices:
      case CellCommand::StartCampaign:
      case CellCommand::StartStream:
        break;
    }
  }
  if (state_name(before) == state()) return std::nullopt;

  state_reason_ = reason;
  const auto* fault = std::get_if<Faulted>(&state_);
  if (fault != nullptr) {
    state_reason_ = fault->reason;
    stream_broke_off_ = was_streaming;
  }
  const std::string since = std::exchange(state_since_, control::rfc3339(parts_.wall_clock()));
  const std::string line =
      "cell " + std::string{state_name(before)} + " -> " + std::string{state()} + ": " + state_reason_;
  fault != nullptr ? log_error(line) : log_info(line);
  parts_.events.publish(
      control::Topic::Cell,
      json::object{{"state", state()}, {"from", state_name(before)}, {"reason", state_reason_}});
  const auto* fault_before = std::get_if<Faulted>(&before);
  if (fault_before != nullptr && fault == nullptr)
    publish_fault(cell_fault(fault_before->reason, since), false);
  if (fault != nullptr) publish_fault(cell_fault(fault->reason, state_since_), true);
  return std::nullopt;
}

DaemonCell::Result DaemonCell::simple_request(const json::object& params, const CellEvent& event,
                                              const std::string& reason) {
  if (auto wrong = no_parameters(params)) return std::unexpected(*wrong);
  if (auto refused = apply(event, reason)) return std::unexpected(*refused);
  return status_json();
}

DaemonCell::Reply DaemonCell::system_config(json::object params) {
  if (auto wrong = no_parameters(params)) co_return std::unexpected(*wrong);
  co_return json::object{{"config", config_json(parts_.config)}};
}

DaemonCell::Reply DaemonCell::cell_status(json::object params) {
  if (auto wrong = no_parameters(params)) co_return std::unexpected(*wrong);
  co_return status_json();
}

DaemonCell::Reply DaemonCell::cell_connect(json::object params) {
  const Result accepted = simple_request(params, ConnectRequested{}, "asked for by an operator");
  if (!accepted) co_return accepted;
  auto identities = co_await devices_.connect();
  if (!identities) {
    apply(ConnectFailed{identities.error().detail}, identities.error().detail);
    co_return std::unexpected(RpcError{ErrorCode::Device, identities.error().detail});
  }
  identities_ = *identities;
  apply(DevicesConnected{}, "robot and tracker are connected, and it is the right arm");
  co_return status_json();
}

DaemonCell::Reply DaemonCell::cell_disconnect(json::object params) {
  co_return simple_request(params, DisconnectRequested{}, "asked for by an operator");
}

DaemonCell::Reply DaemonCell::cell_acknowledge(json::object params) {
  co_return simple_request(params, AcknowledgeRequested{}, "acknowledged by an operator");
}

DaemonCell::Reply DaemonCell::stream_start(json::object params) {
  if (auto wrong = no_parameters(params)) co_return std::unexpected(*wrong);
  if (const std::string why_not = model_trouble(); !why_not.empty()) co_return needs_model(why_not);
  if (auto refused = apply(StreamStartRequested{}, "asked for by an operator"))
    co_return std::unexpected(*refused);
  co_await devices_unasked();
  before_request_ = parts_.stream.status();
  const TimePoint deadline = parts_.clock.now() + kStartProgram;
  auto started = co_await parts_.robot.start_stream_program(deadline);
  if (!started) {
    const std::string reason = "robot: " + started.error().detail;
    apply(StreamFaulted{reason}, reason);
    co_return std::unexpected(RpcError{ErrorCode::Device, reason});
  }
  if (std::holds_alternative<StreamStarting>(state_)) {
    before_stream_ = parts_.stream.status();
    parts_.stream.engage();
    apply(StreamProgramStarted{}, "");
  }
  while (std::holds_alternative<StreamStarting>(state_)) {
    const TimePoint next = parts_.clock.now() + kWatch;
    co_await parts_.clock.sleep_until(next);
  }
  if (const auto* fault = std::get_if<Faulted>(&state_)) {
    co_return std::unexpected(RpcError{ErrorCode::Device, fault->reason});
  }
  co_return stream_now_json();
}

DaemonCell::Reply DaemonCell::stream_stop(json::object params) {
  const Result accepted = simple_request(params, StreamStopRequested{}, "asked for by an operator");
  if (!accepted) co_return accepted;
  while (std::holds_alternative<StreamStopping>(state_)) {
    const TimePoint next = parts_.clock.now() + kWatch;
    co_await parts_.clock.sleep_until(next);
  }
  const TimePoint deadline = parts_.clock.now() + kDeviceAnswer;
  auto stopped = co_await parts_.robot.stop(deadline);
  if (!stopped) on_trouble("robot: " + stopped.error().detail);
  co_return stream_now_json();
}

DaemonCell::Reply DaemonCell::stream_status(json::object params) {
  if (auto wrong = no_parameters(params)) co_return std::unexpected(*wrong);
  co_return stream_now_json();
}

asio::awaitable<void> DaemonCell::watch() {
  using namespace asio::experimental::awaitable_operators;
  co_await (watch_cell() && watch_devices());
}

asio::awaitable<void> DaemonCell::watch_cell() {
  for (TimePoint tell = parts_.clock.now();;) {
    apply(Tick{no_answer(parts_.stream.status())}, "");
    watch_stream();
    if (parts_.clock.now() >= tell) {
      tell = parts_.clock.now() + kTellStream;
      if (streaming()) parts_.events.publish(control::Topic::Stream, stream_now_json());
    }
    const TimePoint next = parts_.clock.now() + kWatch;
    co_await parts_.clock.sleep_until(next);
  }
}

/// A campaign talks with the devices itself. A device that takes its time must not keep watch_cell() waiting.
asio::awaitable<void> DaemonCell::watch_devices() {
  for (TimePoint ask_tracker = parts_.clock.now();;) {
    devices_asked_ = true;
    if (devices_may_be_asked()) co_await watch_robot();
    if (devices_may_be_asked() && parts_.clock.now() >= ask_tracker) {
      co_await watch_tracker();
      ask_tracker = parts_.clock.now() + kAskTracker;
    }
    devices_asked_ = false;
    const TimePoint next = parts_.clock.now() + kAskDevices;
    co_await parts_.clock.sleep_until(next);
  }
}

bool DaemonCell::devices_may_be_asked() const {
  return std::holds_alternative<Ready>(state_) || std::holds_alternative<Streaming>(state_);
}

/// Calls to a device come one at a time.
asio::awaitable<void> DaemonCell::devices_unasked() {
  while (devices_asked_) {
    const TimePoint next = parts_.clock.now() + 10ms;
    co_await parts_.clock.sleep_until(next);
  }
}

/// The stream does without the tracker; whoever is ready to measure does not.
asio::awaitable<void> DaemonCell::watch_tracker() {
  const TimePoint deadline = parts_.clock.now() + kDeviceAnswer;
  auto asked = co_await parts_.tracker.check(deadline);
  const std::string why = asked ? "" : "tracker: " + asked.error().detail;
  if (!asked && std::holds_alternative<Ready>(state_)) apply(DeviceLost{why}, why);
  stand(tracker_lost_, !asked && std::holds_alternative<Streaming>(state_),
        {"E_TRACKER", "warning", why + "; the stream goes on without it", {}});
}

asio::awaitable<void> DaemonCell::watch_robot() {
  const TimePoint deadline = parts_.clock.now() + kDeviceAnswer;
  auto asked = co_await parts_.robot.state(deadline);
  if (asked) {
    robot_state_ = *asked;
  } else if (devices_may_be_asked()) {
    apply(DeviceLost{"robot: " + asked.error().detail}, asked.error().detail);
  }
}

void DaemonCell::watch_stream() {
  const TimePoint now = parts_.clock.now();
  for (StreamEvent event; parts_.stream.next_event(event);) {
    stream_log_.take(event, now);
    if (event.kind == StreamEventKind::Foreign) refused_.foreign = event.source;
    if (event.kind == StreamEventKind::Malformed) refused_.malformed = describe(event);
    if (event.kind == StreamEventKind::Foreign || event.kind == StreamEventKind::Malformed)
      refused_.last = describe(event);
  }
  stream_log_.pass(parts_.stream.dropped_events(), now);

  const StreamStatus status = parts_.stream.status();
  const StreamState before = std::exchange(stream_state_, status.state);
  if (before != status.state) parts_.events.publish(control::Topic::Stream, stream_now_json());
  const bool frozen = status.state == StreamState::Frozen;
  stand(frozen_, frozen, {"E_STREAM_FROZEN", "warning", reason(status), {}});
  if (status.state != StreamState::Unproven || before != status.state) proven_ = now;
  stand(unproven_, now - proven_ >= kUnproven, {"E_STREAM_UNPROVEN", "warning", reason(status), {}});
  watch_silence(silence(status));
  if (status.state == StreamState::Fault) {
    if (streaming()) apply(StreamFaulted{reason(status)}, "");
  } else if (std::holds_alternative<StreamStopping>(state_)) {
    if (status.state == StreamState::Idle) apply(StreamEnded{}, "the correction is ramped out");
  } else if (status.counters.answered > before_stream_.counters.answered) {
    apply(StreamStarted{}, "the controller's packets are answered");
  }
}

/// A controller that falls silent while it is corrected, or should be ramped out, is told at once.
void DaemonCell::watch_silence(std::optional<Duration> lasts) {
  const bool on = std::holds_alternative<Streaming>(state_) || std::holds_alternative<StreamStopping>(state_);
  const bool silent = on && (!lasts || *lasts >= kSilence);
  const bool goes_on_by_itself =
      parts_.config.stream.rearm == config::Rearm::Automatic && std::holds_alternative<Streaming>(state_);
  if (silent && !goes_on_by_itself) {
    apply(
        StreamFaulted{silence_text(lasts) +
                      ", and holds the correction that it has; look at the robot program, the messages on "
                      "the pendant and the cable of the RSI network, then acknowledge, connect and start the "
                      "stream anew"},
        "");
  }
  stand(silent_, silent && goes_on_by_itself,
        {"E_STREAM_SILENT",
         "warning",
         silence_text(lasts) + "; the correction goes on when it does (rearm: automatic)",
         {}});
}

/// Begins or ends a fault that stands as long as its cause.
void DaemonCell::stand(std::optional<Fault>& standing, bool stands, Fault fault) {
  if (stands == standing.has_value()) return;
  if (!stands) {
    publish_fault(*std::exchange(standing, std::nullopt), false);
    return;
  }
  fault.since = control::rfc3339(parts_.wall_clock());
  log_warning(fault.text);
  standing = std::move(fault);
  publish_fault(*standing, true);
}

std::optional<Duration> DaemonCell::packet_age(const StreamStatus& status, TimePoint now) {
  if (!status.heard) return std::nullopt;
  return std::max(Duration{0}, now - *status.heard);
}

asio::awaitable<void> DaemonCell::shut_down() {
  parts_.stream.disengage();
  if (campaign_) campaign_->campaign.abort("the daemon was stopped");
  const TimePoint give_up = parts_.clock.now() + parts_.config.stream.ramp + 5s;
  const auto busy = [this] {
    const StreamState stream = parts_.stream.status().state;
    // A stream that holds for a fault does not ramp: there the controller holds as well.
    const bool holds =
        stream == StreamState::Idle || stream == StreamState::Frozen || stream == StreamState::Fault;
    const bool ramping = streaming() && !holds;
    return ramping || (campaign_ && !campaign_->ended);
  };
  while (busy() && parts_.clock.now() < give_up) {
    const TimePoint next = parts_.clock.now() + kWatch;
    co_await parts_.clock.sleep_until(next);
  }
  if (streaming()) co_await devices_.stop();
  devices_.disconnect();
}

void DaemonCell::publish_fault(const Fault& fault, bool standing) {
  json::object event = fault_json(fault);
  event["standing"] = standing;
  parts_.events.publish(control::Topic::Fault, event);
}

bool DaemonCell::streaming() const {
  return std::holds_alternative<StreamStarting>(state_) || std::holds_alternative<Streaming>(state_) ||
         std::holds_alternative<StreamStopping>(state_);
}

std::string DaemonCell::no_answer(const StreamStatus& now) const {
  return no_answer_text(before_request_, now, refused_, parts_.config);
}

/// Why there is no stream, in the words of the fault that ended it or will end its start.
std::string DaemonCell::stream_trouble(const StreamStatus& now) const {
  if (const auto* fault = std::get_if<Faulted>(&state_)) return stream_broke_off_ ? fault->reason : "";
  const auto* starting = std::get_if<StreamStarting>(&state_);
  const bool late = starting && starting->program_runs && parts_.clock.now() - starting->since >= kSilence;
  return late ? no_answer(now) : "";
}

json::object DaemonCell::stream_now_json() const {
  const StreamStatus status = parts_.stream.status();
  return stream_json(status, parts_.stream.turnaround(),
                     {.streaming = streaming(),
                      .age = packet_age(status, parts_.clock.now()),
                      .refused = refused_.last,
                      .trouble = stream_trouble(status),
                      .model_id = active_ ? active_->record.id : ""});
}

json::object DaemonCell::status_json() const {
  const Identities known = identities_.value_or(Identities{});
  const drivers::RobotState robot = robot_state_.value_or(drivers::RobotState{});
  json::array faults;
  if (const auto* fault = std::get_if<Faulted>(&state_)) {
    faults.push_back(fault_json(cell_fault(fault->reason, state_since_)));
  }
  for (const auto* standing : {&model_fault_, &frozen_, &silent_, &unproven_, &tracker_lost_}) {
    if (*standing) faults.push_back(fault_json(**standing));
  }
  json::array allowed;
  for (const std::string& method : allowed_methods(state_)) allowed.emplace_back(method);
  const bool running = campaign_ && !campaign_->ended;
  return {{"cell", parts_.config.name},
          {"state", state()},
          {"state_text", state_reason_},
          {"allowed", std::move(allowed)},
          {"time", control::rfc3339(parts_.wall_clock())},
          {"robot",
           {{"connected", identities_.has_value()},
            {"model", known.robot.model},
            {"serial", known.robot.serial},
            {"software", known.robot.software},
            {"ready", robot.ready},
            {"why_not_ready", identities_ ? robot.why_not_ready : "not connected"},
            {"q_deg", record::joints_json(robot.q, parts_.config.robot.model)}}},
          {"tracker",
           {{"connected", identities_.has_value() && !tracker_lost_},
            {"model", known.tracker.model},
            {"serial", known.tracker.serial},
            {"firmware", known.tracker.firmware},
            {"why_not_ready", identities_ ? "" : "not connected"}}},
          {"campaign", running ? json::value(progress_json()) : json::value{}},
          {"model", active_ ? json::value(model_json(active_->record)) : json::value{}},
          {"stream", stream_now_json()},
          {"faults", std::move(faults)}};
}

}  // namespace truepose::daemon
