#include "daemon/cell/stream_report.hpp"

#include <algorithm>
#include <boost/json/array.hpp>
#include <boost/json/value.hpp>
#include <boost/json/value_from.hpp>

#include "config/number_text.hpp"
#include "core/formatted.hpp"

namespace truepose::daemon {

namespace json = boost::json;

namespace {

std::string seconds_text(drivers::Duration time) {
  return formatted("%.1f s", std::chrono::duration<double>(time).count());
}

json::value text_json(const std::string& text) { return text.empty() ? json::value{} : json::value(text); }

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

json::value ms_or_null(std::optional<drivers::Duration> age) {
  if (!age) return {};
  return std::chrono::duration_cast<std::chrono::milliseconds>(*age).count();
}

template <typename T>
json::value value_or_null(const std::optional<T>& known) {
  return known ? json::value_from(*known) : json::value{};
}

json::object robot_json(const RobotCondition& robot) {
  return {{"mode", value_or_null(robot.mode)},
          {"override_percent", value_or_null(robot.override_percent)},
          {"program", value_or_null(robot.program)},
          {"emergency_stop", value_or_null(robot.emergency_stop)},
          {"gate_open", value_or_null(robot.gate_open)},
          {"tool_frame", value_or_null(robot.tool_frame)},
          {"base_frame", value_or_null(robot.base_frame)},
          {"load_kg", value_or_null(robot.load_kg)},
          {"unknown", robot.unknown}};
}

json::object percentiles_json(const LatencyHistogram::Summary& summary) {
  return {
      {"p50", summary.p50_us}, {"p99", summary.p99_us}, {"p999", summary.p999_us}, {"max", summary.max_us}};
}

json::object late_json(const StreamCounters& c) {
  return {{"answered", c.replies()},
          {"late", c.late},
          {"daemon", c.late_by_daemon},
          {"machine", c.late_by_machine},
          {"network", c.late_by_network}};
}

json::value scheduling_json(const std::optional<drivers::Scheduling>& thread) {
  if (!thread) return {};
  return {{"policy", thread->policy},
          {"priority", thread->priority},
          {"cpus", json::value_from(thread->cpus)},
          {"locked_kB", thread->locked_kB}};
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

json::object stream_json(const StreamStatus& status, const StreamTimes& times,
                         const StreamSurroundings& around) {
  const StreamCounters& c = status.counters;
  const bool silent = !around.age || *around.age >= kSilence;
  json::array correction_deg, measured_deg;
  if (status.state != StreamState::Idle) {
    for (const double axis_deg : status.correction_deg) correction_deg.emplace_back(axis_deg);
    for (const auto& axis_deg : status.measured_deg) {
      measured_deg.emplace_back(axis_deg && !silent ? json::value(*axis_deg) : json::value{});
    }
  }
  return {
      {"state", stream_state_name(status, around.streaming, silent)},
      {"armed", around.armed},
      {"reason", stream_reason(status, around, silent)},
      {"model_id", text_json(around.model_id)},
      {"tool", {{"number", value_or_null(around.tool)}, {"measured", around.tool_measured}}},
      {"robot", robot_json(around.robot)},
      {"arm",
       {{"serial", text_json(around.serial)},
        {"verified", !around.serial.empty() && around.why_unverified.empty()},
        {"why_not", around.why_unverified}}},
      {"peer", status.peer ? json::value(text(*status.peer)) : json::value{}},
      {"packet_age_ms", ms_or_null(around.age)},
      {"ipoc_step", c.datagrams > 0 && status.ipoc_step > 0 ? json::value(status.ipoc_step) : json::value{}},
      {"sessions", c.sessions},
      {"cycles", c.datagrams},
      {"answered", c.replies()},
      {"held", c.held},
      {"duplicate", c.duplicate},
      {"unconfirmed", c.unconfirmed},
      {"wrong_ipoc", c.wrong_ipoc},
      {"malformed", c.malformed},
      {"partly_read", c.partly_read},
      {"unexpected_sender", c.unexpected_sender},
      {"refused", text_json(around.refused)},
      {"late", c.late},
      {"lost", c.lost},
      {"clamped", c.clamped_step + c.clamped_total + c.clamped_limit + c.clamped_not_finite},
      {"no_solution", c.no_solution},
      {"damped", c.damped},
      {"max_step_deg", status.max_step_deg},
      {"correction_deg", std::move(correction_deg)},
      {"measured_deg", std::move(measured_deg)},
      {"late_by",
       {{"daemon", c.late_by_daemon}, {"machine", c.late_by_machine}, {"network", c.late_by_network}}},
      {"last_minute", late_json(around.last_minute)},
      {"turnaround_us", percentiles_json(times.turnaround)},
      {"compute_us", percentiles_json(times.compute)},
      {"scheduling", scheduling_json(around.thread)}};
}

}  // namespace truepose::daemon
