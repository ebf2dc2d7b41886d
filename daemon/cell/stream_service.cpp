#include "daemon/cell/stream_service.hpp"

#include <algorithm>
#include <utility>

#include "core/planted_bug.hpp"
#include "daemon/log/log.hpp"
#include "daemon/realtime/clamped_axis.hpp"
#include "daemon/store/correction_mark.hpp"
#include "proto/control/json_text.hpp"
#include "proto/eki/messages.hpp"

namespace truepose::daemon {

namespace asio = boost::asio;
using control::ErrorCode;
using control::RpcError;
using namespace std::chrono_literals;

namespace {

// The realtime thread wakes no other thread, which would be a system call. Its status is polled, and a
// controller without packets is reported within half a second.
constexpr Duration kPollInterval = 50ms;
constexpr Duration kReportInterval = 1s;
constexpr Duration kModesDiffer = 5s;  // more than the state server takes to see a change
constexpr Duration kUnconfirmed =
    1s;  // a session that begins shows within some cycles that nothing is in effect
constexpr Duration kDeviceAnswer = 5s;
constexpr Duration kLeave = 2s;  // RSI_OFF follows the Stop bit within some cycles, then kSilence
constexpr Duration kStartProgram = 20s;
constexpr const char* kArmed = "armed";  // what the store may still have to take

std::optional<Duration> packet_age(const StreamStatus& status, TimePoint now) {
  if (!status.heard) return std::nullopt;
  return std::max(Duration{0}, now - *status.heard);
}

/// Of one of the controller's enumerations, by its number there. RSI numbers them as the state server does.
template <typename Enum>
std::optional<std::string> name_of(std::optional<std::int64_t> number, Enum first, Enum last) {
  if (!number || *number < std::to_underlying(first) || *number > std::to_underlying(last))
    return std::nullopt;
  return std::string{name(Enum(*number))};
}

/// Whether the controller is known to have sent nothing for long, or ever.
bool known_stale(const StreamStatus& status) {
  const auto lasts = silence(status);
  return !lasts || *lasts >= kSilence;
}

}  // namespace

StreamService::StreamService(const CellParts& parts, CellRunner& runner, StoreWatch& store,
                             DeviceService& devices, ModelService& models)
    : parts_{parts}, runner_{runner}, store_{store}, devices_{devices}, models_{models}, log_{&log} {
  runner_.on(CellCommand::StopStream, [this](const std::string&) { parts_.stream.leave(); });
  runner_.on(CellCommand::ArmStream, [this](const std::string&) { parts_.stream.arm(); });
  runner_.on(CellCommand::RearmStream, [this](const std::string&) { acknowledge(); });
  runner_.explain_by([this] { return no_answer(parts_.stream.status()); });
}

std::vector<Served<StreamService>> StreamService::methods() {
  return {&StreamService::start, &StreamService::stop, &StreamService::arm, &StreamService::disarm,
          &StreamService::get_status};
}

Reply<rpc::StreamStart> StreamService::start(rpc::StreamStart, std::string by) {
  if (const auto model = models_.needed_to_correct(); !model) co_return std::unexpected(model.error());
  if (auto not_ready = co_await robot_not_ready()) co_return std::unexpected(*not_ready);
  co_await keep_corrected();
  forget_fault_of_past_session();
  if (auto refused = runner_.apply(StreamStartRequested{}, "asked for by an operator", by))
    co_return std::unexpected(*refused);
  before_request_ = parts_.stream.status();
  const TimePoint deadline = parts_.clock.now() + kStartProgram;
  auto started = co_await devices_.robot().start_stream_program(deadline);
  if (!started) {
    const DeviceError error = device_error(started.error());
    runner_.apply(StreamFaulted{{error.detail, error.what_to_do}}, error.detail);
    co_return std::unexpected(RpcError{ErrorCode::Device, runner_.fault_or(error.detail)});
  }
  if (runner_.in<StreamStarting>()) {
    before_stream_ = parts_.stream.status();
    parts_.stream.engage();
    runner_.apply(StreamProgramStarted{}, "");
  }
  co_await runner_.while_in<StreamStarting>();
  if (const auto* fault = runner_.in<Faulted>())
    co_return std::unexpected(RpcError{ErrorCode::Device, fault->reason});
  co_return status();
}

/// What the controller itself says is known at once, and is no reason to let go of it.
asio::awaitable<std::optional<RpcError>> StreamService::robot_not_ready() {
  if (!runner_.in<Ready>()) co_return std::nullopt;
  const TimePoint deadline = parts_.clock.now() + kDeviceAnswer;
  auto state = co_await devices_.robot().state(deadline);
  if (!state || state->ready || !runner_.in<Ready>()) co_return std::nullopt;
  co_return RpcError{ErrorCode::Device,
                     drivers::not_ready_text(state->why_not_ready) + "; then start the stream"};
}

Reply<rpc::StreamStop> StreamService::stop(rpc::StreamStop, std::string by) {
  if (auto frozen = cannot_ramp_out("stream.stop")) co_return std::unexpected(*frozen);
  if (auto refused = runner_.apply(StreamStopRequested{}, "asked for by an operator", by))
    co_return std::unexpected(*refused);
  auto failed = co_await ramped_out<StreamStopping>("stream.stop");
  if (failed) co_return std::unexpected(*failed);
  co_await end_program();
  co_return status();
}

/// The controller does not do what it is sent: what it has in effect stays, whatever is sent.
std::optional<RpcError> StreamService::cannot_ramp_out(const std::string& method) const {
  if (!runner_.corrects() || !runner_.faults().stands(FaultCode::StreamFrozen)) return std::nullopt;
  return runner_.wrong_state(
      "the correction cannot be ramped out: " + runner_.faults().text(FaultCode::StreamFrozen) +
          " (cell.acknowledge), then " + method +
          "; or end the robot program on the pendant, and its RSI and the correction "
          "with it",
      {"cell.acknowledge"});
}

/// Waits until the correction is. @return why it is not
template <typename State>
asio::awaitable<std::optional<RpcError>> StreamService::ramped_out(std::string method) {
  while (runner_.in<State>()) {
    if (auto frozen = cannot_ramp_out(method)) co_return frozen;
    co_await runner_.changed();
  }
  if (const auto* fault = runner_.in<Faulted>()) co_return RpcError{ErrorCode::Device, fault->reason};
  co_return std::nullopt;
}

/// By the Stop bit, which the stream repeats; where no reply can carry it, or RSI stays open, as a motion is
/// stopped.
asio::awaitable<void> StreamService::end_program() {
  const auto is_silent = [this] { return known_stale(parts_.stream.status()); };
  const bool was_silent = is_silent();
  for (const TimePoint end = parts_.clock.now() + kLeave; !is_silent() && parts_.clock.now() < end;) {
    const TimePoint next = parts_.clock.now() + kPollInterval;
    co_await parts_.clock.sleep_until(next);
  }
  if (!was_silent && is_silent()) co_return;
  const TimePoint deadline = parts_.clock.now() + kDeviceAnswer;
  auto stopped = co_await devices_.robot().stop(deadline);
  if (!stopped) log_warning("robot: " + stopped.error().detail);
}

Reply<rpc::StreamArm> StreamService::arm(rpc::StreamArm, std::string by) {
  if (!devices_.robot().connected()) co_await devices_.refresh_robot();
  if (const auto model = models_.needed_to_correct(); !model) co_return std::unexpected(model.error());
  co_await keep_corrected();
  const bool known = devices_.arm_serial().has_value();
  forget_fault_of_past_session();
  if (auto refused = runner_.apply(ArmRequested{}, "armed by an operator", by))
    co_return std::unexpected(*refused);
  verified_ = known;
  auto kept = co_await keep_armed(control::rfc3339(parts_.wall_clock()));
  if (kept) co_return status();
  store_.failed(kept.error());
  runner_.apply(DisarmRequested{}, kept.error().detail);
  co_return std::unexpected(store_unusable(kept.error()));
}

Reply<rpc::StreamDisarm> StreamService::disarm(rpc::StreamDisarm, std::string by) {
  if (auto frozen = cannot_ramp_out("stream.disarm")) co_return std::unexpected(*frozen);
  if (auto refused = runner_.apply(DisarmRequested{}, "disarmed by an operator", by))
    co_return std::unexpected(*refused);
  co_await keep_disarmed();
  auto failed = co_await ramped_out<Disarming>("stream.disarm");
  if (failed) co_return std::unexpected(*failed);
  co_return status();
}

/// Before anything is corrected. Where the disk does not keep it the stream continues: what is lost is a
/// proof for simulators that outlive a restart of this machine.
asio::awaitable<void> StreamService::keep_corrected() {
  auto job = [this] { return daemon::keep_corrected(parts_.config.store); };
  const auto kept = co_await parts_.store_thread.ask(job);
  if (!kept) log_error(kept.error().detail);
}

asio::awaitable<StoreResult<void>> StreamService::keep_armed(std::string since) {
  store_.forget(kArmed);
  kept_armed_ = true;
  auto job = [this, since] { return parts_.store.keep_armed(since); };
  co_return co_await parts_.store_thread.ask(job);
}

asio::awaitable<void> StreamService::keep_disarmed() {
  kept_armed_ = false;
  auto job = [this] { return parts_.store.keep_armed(""); };
  co_await store_.keep(kArmed, job);
}

asio::awaitable<void> StreamService::arm_as_before() {
  auto job = [this] { return parts_.store.armed_since(); };
  auto since = co_await parts_.store_thread.ask(job);
  if (!since) log_error("whether the stream was armed is not known: " + since.error().detail);
  if (!since || since->empty() || planted("an armed stream is forgotten at a restart")) co_return;
  kept_armed_ = true;
  co_await devices_.refresh_robot();
  if (const auto model = models_.needed_to_correct(); !model) {
    log_warning("the stream, armed since " + *since + ", is disarmed: " + model.error().message);
    co_await keep_disarmed();
    co_return;
  }
  co_await keep_corrected();
  runner_.apply(ArmRequested{}, "armed since " + *since + ", as before the daemon ended");
}

Reply<rpc::GetStreamStatus> StreamService::get_status(rpc::GetStreamStatus) { co_return status(); }

asio::awaitable<void> StreamService::watch() {
  for (TimePoint tell = parts_.clock.now();;) {
    look();
    if (kept_armed_ && runner_.in<Faulted>()) co_await keep_disarmed();  // acknowledging arms again
    if (parts_.clock.now() >= tell) {
      tell = parts_.clock.now() + kReportInterval;
      if (runner_.corrects()) parts_.events.publish(status(), Keep::Passing);
    }
    const TimePoint next = parts_.clock.now() + kPollInterval;
    co_await parts_.clock.sleep_until(next);
  }
}

/// An operator does not see the fault of a program that was not corrected, and cannot acknowledge it.
void StreamService::forget_fault_of_past_session() {
  const StreamStatus status = parts_.stream.status();
  if (status.state == StreamState::Fault && known_stale(status) && !runner_.corrects()) acknowledge();
}

/// At once, so that what the fault rules out can be asked for; the realtime thread sees it in its next cycle.
void StreamService::acknowledge() {
  acknowledged_ = parts_.stream.acknowledge();
  runner_.faults().end(FaultCode::StreamFrozen);
}

void StreamService::take_events() {
  const TimePoint now = parts_.clock.now();
  for (StreamEvent event; parts_.stream.next_event(event);) {
    log_.take(event, now);
    if (event.kind == StreamEventKind::Foreign) refused_.foreign = event.source;
    if (event.kind == StreamEventKind::Malformed) refused_.malformed = describe(event);
    if (event.kind == StreamEventKind::Foreign || event.kind == StreamEventKind::Malformed)
      refused_.last = describe(event);
  }
  log_.pass(parts_.stream.dropped_events(), now);
}

void StreamService::look() {
  take_events();
  const TimePoint now = parts_.clock.now();
  const StreamStatus status = parts_.stream.status();
  last_minute_.take(status.counters, now);
  const StreamState before = std::exchange(state_, status.state);
  // With a session that is over, what it had in effect is too.
  const bool over = known_stale(status) && !runner_.streaming();
  const bool acknowledged = status.acknowledged != acknowledged_;  // and not yet seen
  const bool frozen = status.state == StreamState::Frozen;
  const bool clamped = frozen && clamped_axis(status);
  // Seen later than that the axes do not follow: the fault begins once more, with its cause.
  if (clamped && !clamp_named_) runner_.faults().end(FaultCode::StreamFrozen);
  clamp_named_ = clamped || (frozen && clamp_named_);
  runner_.faults().stand(frozen && !over && !acknowledged, {FaultCode::StreamFrozen, reason(status)});
  if (before != status.state) {
    parts_.events.publish(this->status());
    runner_.wake();
  }
  if (status.state != StreamState::Unproven || before != status.state || over) proven_ = now;
  runner_.faults().stand(now - proven_ >= kUnconfirmed, {FaultCode::StreamUnconfirmed, reason(status)});
  compare_modes(status);
  refresh_robot(status);
  check_serial_number(status);
  look_for_silence(status);
  follow(status);
}

/// By RSI what that says, which is sooner and needs no more than itself; the rest by the state server.
RobotCondition StreamService::robot(const StreamStatus& status) const {
  RobotCondition robot;
  if (const auto state = devices_.robot_state()) {
    robot = {.mode = state->mode,
             .override_percent = state->override_percent,
             .program = state->program,
             .emergency_stop = state->emergency_stop,
             .gate_open = state->gate_open,
             .tool_frame = state->tool_frame,
             .base_frame = state->base_frame,
             .load_kg = state->load_kg};
  } else {
    robot.unknown = state.error();
  }
  if (known_stale(status)) return robot;
  using eki::OperatingMode, eki::ProgramState;
  auto mode = name_of(status.mode, OperatingMode::T1, OperatingMode::Ext);
  if (mode && !mode_differs_) robot.mode = std::move(mode);
  if (auto program = name_of(status.program, ProgramState::Free, ProgramState::Ended))
    robot.program = std::move(program);
  if (status.override_percent) robot.override_percent = static_cast<double>(*status.override_percent);
  if (const auto& signals = controller_signals_.signals()) {
    robot.emergency_stop = signals->emergency_stop;
    robot.gate_open = signals->gate_open;
  }
  if (robot.mode && robot.program && robot.override_percent && robot.emergency_stop && robot.gate_open)
    robot.unknown.clear();
  return robot;
}

void StreamService::refresh_robot(const StreamStatus& status) {
  controller_signals_.take(known_stale(status) ? std::nullopt : status.cell, parts_.clock.now());
  // What does not come again is as it was. The frame is of the tool that the state server names with it.
  const auto state = devices_.robot_state();
  const auto& by_rsi = controller_signals_.signals();
  const bool other_tool = by_rsi && (!tool_by_rsi_ || *tool_by_rsi_ != by_rsi->tool);
  tool_by_rsi_ = by_rsi ? std::optional{by_rsi->tool} : std::nullopt;
  if (other_tool) devices_.ask_soon();  // for its frame
  if (by_rsi) {
    models_.controller_has(by_rsi->tool,
                           state && state->tool == by_rsi->tool ? state->tool_frame : std::nullopt);
  } else if (state) {
    models_.controller_has(state->tool, state->tool_frame);
  }
  RobotCondition now = robot(status);
  if (now == robot_) return;
  robot_ = std::move(now);
  if (!runner_.corrects()) return;
  log_info("robot: " + describe(robot_));
  parts_.events.publish(this->status());
}

/// Whether RSI and the state server name another mode for longer than the state server takes to see a change:
/// then the context sends something else as Tp.Mode, and the state server is believed, which reads $MODE_OP
/// by its name.
void StreamService::compare_modes(const StreamStatus& status) {
  const TimePoint now = parts_.clock.now();
  const auto by_rsi = name_of(status.mode, eki::OperatingMode::T1, eki::OperatingMode::Ext);
  const auto state = devices_.robot_state();
  const bool differ =
      !known_stale(status) && by_rsi && state && !state->mode.empty() && state->mode != *by_rsi;
  if (!differ) modes_agreed_ = now;
  mode_differs_ = now - modes_agreed_ >= kModesDiffer;
  runner_.faults().stand(
      mode_differs_,
      {FaultCode::Mode,
       differ ? "RSI says that the operating mode is " + *by_rsi + ", CellState that it is " + state->mode +
                    ": the context sends something else as Tp.Mode. Load the context of this version, and "
                    "look at it with truepose kuka lint"
              : ""});
}

/// Checks the serial number of an armed stream's arm. The state server may report it. If that server does not
/// answer and RSI is closed, the next controller may be another one. It is corrected only after it has
/// reported the expected serial number. A controller that never reports one is corrected.
void StreamService::check_serial_number(const StreamStatus& status) {
  const bool armed = runner_.in<Armed>() != nullptr;
  const bool serial_known = armed && devices_.arm_serial();
  if (const auto lack = models_.missing_for_correction(); armed && serial_known && models_.active() && lack) {
    runner_.apply(StreamFaulted{{lack->why, lack->what_to_do}}, "");
    return;
  }
  const bool was_to_wait = waits_for_serial();
  if (serial_known) verified_ = reports_serial_ = true;
  if (armed && !serial_known && known_stale(status)) verified_ = false;
  if (waits_for_serial() && !was_to_wait) parts_.stream.disengage();
  if (!waits_for_serial() && was_to_wait && armed) parts_.stream.arm();
  runner_.faults().stand(waits_for_serial() && !known_stale(status), {FaultCode::Arm, why_unverified()});
}

bool StreamService::waits_for_serial() const {
  return runner_.in<Armed>() != nullptr && reports_serial_ && !verified_;
}

std::string StreamService::why_unverified() const {
  if (!models_.active() || (runner_.armed() ? verified_ : devices_.arm_serial().has_value())) return {};
  const std::string which = "whether the arm is " + models_.active()->record.robot_serial +
                            ", the arm of the active model, is not verified: ";
  if (waits_for_serial())
    return which +
           "its controller was away, and its state server (CellState) does not answer; nothing is "
           "corrected before it sends the serial number";
  if (!runner_.armed()) return which + "it is not connected";
  return which +
         "its state server (CellState) sends no serial number, as CellState.xml and truepose_state of this "
         "version do; load these, or disarm the stream, connect, which compares it, and arm it again";
}

/// Reports at once that a controller stopped sending while it is corrected or ramped out.
void StreamService::look_for_silence(const StreamStatus& status) {
  const auto lasts = silence(status);
  const bool on = runner_.in<Streaming>() || runner_.in<StreamStopping>();
  const bool silent = on && known_stale(status);
  const bool goes_on_by_itself =
      parts_.config.stream.rearm == config::Rearm::Automatic && runner_.in<Streaming>();
  if (silent && !goes_on_by_itself) {
    runner_.apply(StreamFaulted{{silence_text(lasts) + ", and holds the correction that it has",
                                 "look at the robot program, the messages on the pendant and the cable of "
                                 "the RSI network"}},
                  "");
  }
  const bool waits = silent && goes_on_by_itself;
  runner_.faults().stand(
      waits, {FaultCode::StreamTimeout,
              silence_text(lasts) + "; the correction resumes with the next one (rearm: automatic)"});
  if (runner_.in<Streaming>()) runner_.await(CellDevice::Controller, waits ? "it sends no RSI packet" : "");
}

void StreamService::follow(const StreamStatus& status) {
  if (status.state == StreamState::Fault) {
    if (runner_.corrects() && status.acknowledged == acknowledged_)
      runner_.apply(StreamFaulted{why_faulted(status)}, "");
  } else if (runner_.in<StreamStopping>()) {
    if (status.state == StreamState::Idle) runner_.apply(StreamEnded{}, "the correction is ramped out");
  } else if (runner_.in<Disarming>()) {
    if (status.state == StreamState::Idle) runner_.apply(StreamEnded{}, "disarmed: nothing is corrected");
    if (known_stale(status)) {
      acknowledge();  // what the last session may have left
      runner_.apply(StreamEnded{}, "disarmed: no program has RSI open");
    }
  } else if (status.counters.answered > before_stream_.counters.answered) {
    runner_.apply(StreamStarted{}, "the controller's packets are answered");
  }
}

/// The realtime thread does not know that the controller has another frame than the measured one, and that by
/// it alone a correction may be out of reach.
FaultText StreamService::why_faulted(const StreamStatus& status) const {
  const std::string other_frame = runner_.faults().text(FaultCode::ToolData);
  const bool is_too_large =
      status.fault == StreamFault::NoSolution || status.fault == StreamFault::BoundBroken;
  if (!is_too_large || other_frame.empty()) return fault_text(status);
  return {"the correction is out of reach: " + other_frame};
}

bool StreamService::in_effect() const {
  const StreamState stream = parts_.stream.status().state;
  // A stream that holds for a fault does not ramp: there the controller holds as well.
  const bool holds =
      stream == StreamState::Idle || stream == StreamState::Frozen || stream == StreamState::Fault;
  return runner_.corrects() && !holds && !(runner_.armed() && known_stale(parts_.stream.status()));
}

std::string StreamService::no_answer(const StreamStatus& now) const {
  return no_answer_text(before_request_, now, refused_, parts_.config);
}

/// Why there is no stream, in the words of the fault that ended it or will end its start.
std::string StreamService::trouble(const StreamStatus& now) const {
  if (const auto* fault = runner_.in<Faulted>()) return runner_.faulted_in_stream() ? fault->reason : "";
  if (waits_for_serial() && !known_stale(now)) return why_unverified();
  const auto* starting = runner_.in<StreamStarting>();
  const bool late = starting && starting->program_runs && parts_.clock.now() - starting->since >= kSilence;
  return late ? no_answer(now) : "";
}

rpc::StreamStatus StreamService::status() const {
  const StreamStatus status = parts_.stream.status();
  return stream_status(
      status, {parts_.stream.turnaround(), parts_.stream.compute()},
      {.streaming = runner_.corrects(),
       .armed = runner_.armed(),
       .age = packet_age(status, parts_.clock.now()),
       .refused = refused_.last,
       .trouble = trouble(status),
       .frozen = status.state == StreamState::Frozen ? runner_.faults().text(FaultCode::StreamFrozen) : "",
       .model_id = models_.active() ? models_.active()->record.id : "",
       .tool = models_.tool().number,
       .tool_measured = models_.tool().is_measured,
       .robot = robot(status),
       .serial = models_.active() ? models_.active()->record.robot_serial : "",
       .why_unverified = why_unverified(),
       .thread = parts_.realtime_thread ? std::optional{parts_.realtime_thread()} : std::nullopt,
       .last_minute = last_minute_.of(status.counters)});
}

}  // namespace truepose::daemon
