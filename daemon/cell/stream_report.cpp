#include "daemon/cell/stream_report.hpp"

#include <algorithm>

#include "config/number_text.hpp"
#include "core/formatted.hpp"
#include "daemon/cell/service.hpp"

namespace truepose::daemon {

namespace {

std::string seconds_text(drivers::Duration time) {
  return formatted("%.1f s", std::chrono::duration<double>(time).count());
}

/// Without a model the correction goes to zero, and nothing is corrected from then on.
std::string_view modelless_state_name(const StreamStatus& status) {
  const bool zero = std::ranges::all_of(status.correction_deg, [](double axis_deg) { return axis_deg == 0; });
  return zero ? "waiting" : "ramping";
}

/// A stream without packets waits, whatever it did before.
std::string_view stream_state_name(const StreamStatus& status, bool streaming, bool silent) {
  switch (status.state) {
    case StreamState::Fault:
      return "fault";
    case StreamState::Idle:
      return streaming ? "waiting" : "off";
    case StreamState::Unproven:
      return "waiting";
    case StreamState::RampingIn:
    case StreamState::RampingOut:
      if (silent) return "waiting";
      return status.program_stopped ? "holding" : "ramping";
    case StreamState::Active:
      if (silent) return "waiting";
      if (status.program_stopped) return "holding";
      return status.model == 0 ? modelless_state_name(status) : "correcting";
    case StreamState::Frozen:
      return silent ? "waiting" : "holding";
  }
  return "fault";
}

std::optional<std::int64_t> ms_or_none(std::optional<drivers::Duration> age) {
  if (!age) return std::nullopt;
  return std::chrono::duration_cast<std::chrono::milliseconds>(*age).count();
}

rpc::Percentiles percentiles_of(const LatencyHistogram::Summary& summary) {
  return {.p50 = summary.p50_us, .p99 = summary.p99_us, .p999 = summary.p999_us, .max = summary.max_us};
}

std::optional<rpc::StreamScheduling> scheduling_of(const std::optional<drivers::Scheduling>& thread) {
  if (!thread) return std::nullopt;
  return rpc::StreamScheduling{.policy = thread->policy,
                               .priority = thread->priority,
                               .cpus = thread->cpus,
                               .locked_kB = thread->locked_kB};
}

/// Of an armed stream whose controller sends nothing.
std::string closed_text(const StreamStatus& status, std::optional<drivers::Duration> age) {
  const auto known = silence(status);
  if (age && known && *known < kSilence) return old_packet_text(status, age);
  const std::string last = age ? ", the last packet came " + seconds_text(*age) + " ago" : std::string{};
  return "armed; no program has RSI open" + last;
}

/// What ended the stream, or will end its start, before all else; of a controller that is silent nothing else
/// matters.
std::string stream_reason(const StreamStatus& status, const StreamSurroundings& around, bool silent) {
  if (!around.trouble.empty()) return around.trouble;
  silent = silent && around.streaming;
  const bool of_its_packets = status.state == StreamState::Unproven || status.state == StreamState::Frozen;
  const bool pressed = around.streaming && !silent && around.robot.emergency_stop.value_or(false);
  const std::string why = around.frozen.empty() ? reason(status) : around.frozen;
  if (!why.empty() && !(of_its_packets && silent))
    return pressed ? "an emergency stop is pressed; " + why : why;
  if (silent) return around.armed ? closed_text(status, around.age) : old_packet_text(status, around.age);
  if (pressed) return "an emergency stop is pressed";
  return around.streaming && status.model == 0
             ? "no model is active: nothing is corrected; activate one, or stop the stream"
             : "";
}

}  // namespace

std::string describe(const RobotCondition& robot) {
  std::string text;
  const auto add = [&](const std::string& part) { text += (text.empty() ? "" : ", ") + part; };
  if (robot.mode) add("mode " + *robot.mode);
  if (robot.override_percent) add("override " + formatted("%.0f", *robot.override_percent) + " %");
  if (robot.program) add("program " + *robot.program);
  if (robot.emergency_stop.value_or(false)) add("emergency stop pressed");
  if (robot.gate_open.value_or(false)) add("safety gate open");
  if (!robot.unknown.empty()) add((text.empty() ? "not known: " : "the rest is not known: ") + robot.unknown);
  return text;
}

std::string silence_text(std::optional<drivers::Duration> silence) {
  if (!silence) return "the controller has sent no RSI packet yet";
  return "the controller has sent no RSI packet for " + seconds_text(*silence);
}

std::string old_packet_text(const StreamStatus& status, std::optional<drivers::Duration> age) {
  const auto known = silence(status);
  if (!age || !known || *known >= kSilence) return silence_text(age);
  return "this PC has not run truepose's RSI thread for " + seconds_text(*age - *known) +
         ": look at its load, and at the scheduling that the log names at the start";
}

std::string no_answer_text(const StreamStatus& before, const StreamStatus& now, const RefusedPackets& refused,
                           const config::CellConfig& config) {
  if (const FaultText fault = fault_text(now); !fault.what.empty())
    return fault.what + "; " + fault.what_to_do;
  if (std::string why = reason(now); !why.empty()) return why;
  const StreamCounters &was = before.counters, &is = now.counters;
  const std::string port = config::text(config.stream.listen);
  const std::string file = config.stream.ethernet_xml.string();
  if (is.malformed > was.malformed) {
    return std::to_string(is.malformed - was.malformed) + " packets came to " + port +
           " and none was understood: " + refused.malformed +
           "; the ethernet configuration on the controller must be the one that truepose reads, " + file +
           ": load that one there";
  }
  if (is.unexpected_sender > was.unexpected_sender && refused.foreign) {
    return std::to_string(is.unexpected_sender - was.unexpected_sender) + " packets came to " + port +
           ", but not from the controller (" + config.robot.rsi_peer + "): the last new sender is " +
           text(*refused.foreign) +
           "; if that is the controller's address in the RSI network, give it as robot.rsi_peer and restart "
           "trueposed; else look where the controller sends to, and stop that sender";
  }
  if (is.wrong_ipoc > was.wrong_ipoc || is.unconfirmed > was.unconfirmed)
    return "the controller's packets follow no order: its IPOC does not rise from packet to packet; "
           "look whether a second program sends there, and start the robot program again";
  return "no packet came to " + port +
         ": this address must be IP_NUMBER and PORT of the ethernet configuration on the controller (here " +
         file +
         "), its RSI network must be the one of this card, no firewall may drop UDP, and the program must "
         "have come to RSI_ON; where the pendant shows RSITimeout, it has, and the packets go elsewhere; run "
         "`truepose doctor`, which looks where";
}

rpc::StreamStatus stream_status(const StreamStatus& status, const StreamTimes& times,
                                const StreamSurroundings& around) {
  const StreamCounters& c = status.counters;
  const StreamCounters& minute = around.last_minute;
  const bool silent = !around.age || *around.age >= kSilence;
  rpc::StreamStatus answer{
      .state = std::string{stream_state_name(status, around.streaming, silent)},
      .armed = around.armed,
      .reason = stream_reason(status, around, silent),
      .model_id = text_or_none(around.model_id),
      .tool = {.number = around.tool, .measured = around.tool_measured},
      .robot = around.robot,
      .arm = {.serial = text_or_none(around.serial),
              .verified = !around.serial.empty() && around.why_unverified.empty(),
              .why_not = around.why_unverified},
      .packet_age_ms = ms_or_none(around.age),
      .sessions = c.sessions,
      .cycles = c.datagrams,
      .answered = c.replies(),
      .held = c.held,
      .duplicate = c.duplicate,
      .unconfirmed = c.unconfirmed,
      .malformed = c.malformed,
      .partly_read = c.partly_read,
      .unexpected_sender = c.unexpected_sender,
      .refused = text_or_none(around.refused),
      .late = c.late,
      .lost = c.lost,
      .wrong_ipoc = c.wrong_ipoc,
      .clamped = c.clamped_step + c.clamped_total + c.clamped_limit + c.clamped_not_finite,
      .no_solution = c.no_solution,
      .damped = c.damped,
      .max_step_deg = status.max_step_deg,
      .late_by = {.daemon = c.late_by_daemon, .machine = c.late_by_machine, .network = c.late_by_network},
      .last_minute = {.answered = minute.replies(),
                      .late = minute.late,
                      .daemon = minute.late_by_daemon,
                      .machine = minute.late_by_machine,
                      .network = minute.late_by_network},
      .turnaround_us = percentiles_of(times.turnaround),
      .compute_us = percentiles_of(times.compute),
      .scheduling = scheduling_of(around.thread)};
  if (status.peer) answer.peer = text(*status.peer);
  if (c.datagrams > 0 && status.ipoc_step > 0) answer.ipoc_step = status.ipoc_step;
  if (status.state == StreamState::Idle) return answer;
  answer.correction_deg.assign(status.correction_deg.begin(), status.correction_deg.end());
  answer.measured_deg.assign(status.measured_deg.begin(), status.measured_deg.end());
  if (silent) std::ranges::fill(answer.measured_deg, std::nullopt);
  return answer;
}

}  // namespace truepose::daemon
