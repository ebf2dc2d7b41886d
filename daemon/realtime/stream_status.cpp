#include "daemon/realtime/stream_status.hpp"

#include <algorithm>

#include "core/formatted.hpp"
#include "daemon/realtime/clamped_axis.hpp"

namespace truepose::daemon {

namespace {

std::string deg(double value) { return formatted("%.3f deg", value); }

std::string axis(const FaultDetail& detail) { return "A" + std::to_string(detail.axis); }

/// What an element is watched for.
std::string_view shown_by(std::string_view element) {
  if (element == "Delay") return "which replies it has taken";
  if (element == "AIPos") return "whether the arm follows the correction";
  return "whether it is the arm of robot.file";
}

FaultText text_of(StreamFault fault, const FaultDetail& detail) {
  switch (fault) {
    case StreamFault::None:
      return {};
    case StreamFault::NotFollowing:
      return {
          "the axes do not follow the correction: " + axis(detail) + " is sent " + deg(detail.limit) +
              " and AIPos - ASPos shows " + formatted("%.2f", detail.value) + " +- " +
              formatted("%.2f", detail.uncertain) + " deg" +
              "; the robot program is stopped or not at RSI_MOVECORR; or the ethernet configuration on the "
              "controller only sends (ONLYSEND), or has another name for the correction than stream.ethernet_xml; "
              "or the RSI context does not lead it to AXISCORR",
          "correct that one"};
    case StreamFault::BoundBroken:
      return {"the model asked for more than the correction bounds allow for too long: " + axis(detail) +
                  " by " + deg(detail.value) + ", where the bound is " + deg(detail.limit),
              "check the model and the bounds"};
    case StreamFault::NoSolution:
      return {
          "the calibrated arm cannot reach the commanded poses, or only by corrections as large as a "
          "singularity asks for",
          "check the program and the model"};
    case StreamFault::JointLimit:
      return {axis(detail) + " with its correction is at " + deg(detail.value) + ", beyond its limit of " +
                  deg(detail.limit) + " (robot.file, less stream.limit_margin_deg)",
              "move the program's points inside the limit, or correct the limit in robot.file"};
    case StreamFault::RepliesRejected:
      return {
          "the controller takes no reply, though all were sent in time: the ethernet configuration on it has "
          "another SENTYPE or other names than the one that truepose reads (stream.ethernet_xml), or the "
          "network delays or loses them",
          "load that configuration there; if it is there, look at the switch and the cable of the RSI network"};
    case StreamFault::WrongCycle:
      return {"the controller's IPOC rises by " + formatted("%.0f", detail.value) +
                  " from packet to packet, but stream.cycle_ms is " + formatted("%.0f", detail.limit) +
                  (detail.ports[0] == 0
                       ? ""
                       : ", and its address sent from port " + std::to_string(detail.ports[0]) +
                             ", and within a second from port " + std::to_string(detail.ports[1])),
              "set stream.cycle_ms to " + formatted("%.0f", detail.value) +
                  " and restart trueposed, or start RSI in the configured cycle (#IPO_FAST 4, #IPO 12)" +
                  std::string{detail.ports[0] == 0 ? "" : ", or end the second program that sends there"}};
    case StreamFault::NotSent: {
      const std::string element{detail.element};
      return {"the controller's packets have no " + element + " that can be read, and it alone shows " +
                  std::string{shown_by(element)} +
                  ": the ethernet configuration on the controller is another than the one that truepose "
                  "reads (stream.ethernet_xml), which sends DEF_" +
                  element,
              "load that one there"};
    }
    case StreamFault::WrongArm:
      return {"the controller's pose RIst is " + formatted("%.1f", detail.value) +
                  " mm from where the robot file's arm has its flange at AIPos (allowed " +
                  formatted("%.1f", detail.limit) +
                  "): it is another arm, or the program has a tool or a base",
              "correct robot.file, or start RSI with tool 0 and base 0 (BAS(#TOOL,0) and BAS(#BASE,0) "
              "before RSI_ON)"};
  }
  return {};
}

FaultText clamp_text(const ClampedAxis& clamped) {
  return {"the controller clamps the correction: A" + std::to_string(clamped.axis) + " is sent " +
              deg(clamped.sent_deg) + " and stands at " + formatted("%.2f deg", clamped.stands_deg) +
              ", a limit of AXISCORR in its RSI context (LowerLim and UpperLim, or RSI's default)",
          "set both beyond stream.max_total_deg there, load that context and start the robot program again"};
}

std::string counted(std::uint64_t count, const std::string& singular, const std::string& plural) {
  return std::to_string(count) + ' ' + (count == 1 ? singular : plural);
}

std::string degrees(std::uint64_t microdegrees) { return deg(static_cast<double>(microdegrees) * 1e-6); }

/// "ASPos.A2 is missing (at byte 30); it begins `<Rob Type="KUKA">`"
std::string error_text(const StreamEvent& event) {
  return rsi::describe(event.error) + (event.excerpt.begin == 0 ? "; it begins `" : "; there it reads `") +
         event.excerpt.text() + "`";
}

bool always_said(StreamEventKind kind) {
  return kind == StreamEventKind::StateChanged || kind == StreamEventKind::ModelChanged ||
         kind == StreamEventKind::SessionProven || kind == StreamEventKind::Foreign ||
         kind == StreamEventKind::Disarmed;
}

LogLevel level_of(const StreamEvent& event) {
  switch (event.kind) {
    case StreamEventKind::SessionStarted:
    case StreamEventKind::SessionProven:
    case StreamEventKind::ModelChanged:
      return LogLevel::Info;
    case StreamEventKind::StateChanged:
      if (event.state == StreamState::Fault) return LogLevel::Error;
      return event.state == StreamState::Frozen ? LogLevel::Warning : LogLevel::Info;
    case StreamEventKind::Foreign:
    case StreamEventKind::Disarmed:
    case StreamEventKind::Malformed:
    case StreamEventKind::PartlyRead:
    case StreamEventKind::PacketsLost:
    case StreamEventKind::RepliesLate:
      return LogLevel::Warning;
  }
  return LogLevel::Warning;
}

}  // namespace

std::string_view name(StreamState state) {
  switch (state) {
    case StreamState::Idle:
      return "idle";
    case StreamState::Unproven:
      return "unconfirmed";
    case StreamState::RampingIn:
      return "ramping in";
    case StreamState::Active:
      return "active";
    case StreamState::RampingOut:
      return "ramping out";
    case StreamState::Frozen:
      return "frozen";
    case StreamState::Fault:
      return "fault";
  }
  return "unknown";
}

std::optional<drivers::Duration> silence(const StreamStatus& status) {
  if (!status.heard) return std::nullopt;
  return std::max(drivers::Duration{0}, status.read_until - *status.heard);
}

FaultText fault_text(const StreamStatus& status) {
  const auto clamped = status.fault == StreamFault::NotFollowing ? clamped_axis(status) : std::nullopt;
  return clamped ? clamp_text(*clamped) : text_of(status.fault, status.detail);
}

std::string reason(const StreamStatus& status) {
  if (status.state == StreamState::Unproven && status.peer_waits)
    return "the sender repeats its frame until it is answered, as simulators do, and may have a correction in effect: "
           "start it again, with an IPOC that begins at 0";
  if (status.state == StreamState::Unproven)
    return "the correction in effect at the controller is not known, and any answer could be a jump: it is "
           "answered as soon as the arm stands, or has a new session and no correction";
  if (status.fault != StreamFault::None) return sentence(fault_text(status), "acknowledge");
  if (status.program_stopped) return "the robot program is stopped: the correction is held until it resumes";
  if (status.program_declines && status.state == StreamState::Idle)
    return "the robot program does not ask to be corrected (Tp.Ask is 0): TP_BEGIN() does, or $SEN_PINT[1]=1";
  return "";
}

std::string Excerpt::text() const {
  std::string text{bytes.data(), size};
  std::ranges::replace_if(
      text, [](char c) { return c < ' ' || c > '~'; }, '.');
  return text;
}

std::string describe(const StreamEvent& event) {
  const std::string at = " at IPOC " + std::to_string(event.ipoc);
  switch (event.kind) {
    case StreamEventKind::SessionStarted:
      return "the controller began a session at IPOC " + std::to_string(event.value) + " from " +
             text(event.source);
    case StreamEventKind::SessionProven:
      return "the correction in effect at the controller is known" + at + ": at most " +
             degrees(event.value) + " on an axis";
    case StreamEventKind::StateChanged: {
      const std::string why = reason({.state = event.state, .fault = event.fault, .detail = event.detail});
      return std::string{name(event.state)} + (why.empty() ? "" : at + ": " + why);
    }
    case StreamEventKind::Malformed:
      return "a packet of " + text(event.source) + " was not understood" +
             (event.ipoc == 0 ? "" : " after IPOC " + std::to_string(event.ipoc)) + ": " + error_text(event);
    case StreamEventKind::PartlyRead:
      return "the packets of " + text(event.source) + " can be read in part alone" + at + ": " +
             error_text(event);
    case StreamEventKind::PacketsLost:
      return counted(event.value, "cycle", "cycles") + " lost before IPOC " + std::to_string(event.ipoc);
    case StreamEventKind::RepliesLate:
      return "the controller counted " + counted(event.value, "late reply", "late replies") + at;
    case StreamEventKind::ModelChanged:
      return event.value == 0 ? "no model is in use" : "another model is in use";
    case StreamEventKind::Foreign:
      return "packets of " + text(event.source) +
             " are dropped: the controller is expected at robot.rsi_peer (left out: the host of "
             "robot.eki_motion) and at the port that its session began with; if this is its address in the "
             "RSI network, give it as robot.rsi_peer, else stop that sender";
    case StreamEventKind::Disarmed:
      return "the controller was silent for " + std::to_string(event.value) +
             " ms: the correction is ramped out until the stream is started again";
  }
  return {};
}

namespace {

/// What was added up of one kind.
std::string sum_line(StreamEventKind kind, std::uint64_t events, std::uint64_t values) {
  const std::string in = " in " + std::to_string(StreamLog::kQuiet.count()) + " s";
  switch (kind) {
    case StreamEventKind::SessionStarted:
      return counted(events, "more session", "more sessions") + " of the controller" + in;
    case StreamEventKind::Malformed:
      return counted(events, "more row", "more rows") + " of packets that were not understood" + in;
    case StreamEventKind::PartlyRead:
      return counted(events, "more session", "more sessions") + " of packets that were read in part" + in;
    case StreamEventKind::PacketsLost:
      return counted(values, "more cycle", "more cycles") + " lost in " + counted(events, "gap", "gaps") + in;
    case StreamEventKind::RepliesLate:
      return counted(values, "more late reply", "more late replies") + in;
    case StreamEventKind::SessionProven:
    case StreamEventKind::Foreign:
    case StreamEventKind::Disarmed:
    case StreamEventKind::StateChanged:
    case StreamEventKind::ModelChanged:
      break;
  }
  return {};
}

}  // namespace

void StreamLog::take(const StreamEvent& event, drivers::TimePoint now) {
  // Every session begins so, for some cycles; who watches the stream says it where it lasts.
  if (event.kind == StreamEventKind::StateChanged && event.state == StreamState::Unproven) return;
  if (always_said(event.kind)) {
    say_(level_of(event), "stream: " + describe(event));
    return;
  }
  end_silence(event.kind, now);
  Silence& silence = silences_[static_cast<std::size_t>(event.kind)];
  if (silence.begun) {
    ++silence.events;
    silence.values += event.value;
    return;
  }
  silence = {.begun = true, .end = now + kQuiet};
  say_(level_of(event), "stream: " + describe(event));
}

void StreamLog::pass(std::uint64_t dropped, drivers::TimePoint now) {
  for (std::size_t i = 0; i < silences_.size(); ++i) end_silence(static_cast<StreamEventKind>(i), now);
  if (dropped > dropped_) {
    say_(LogLevel::Warning,
         "stream: " + counted(dropped - dropped_, "event", "events") + " came too fast and were dropped");
    dropped_ = dropped;
  }
}

void StreamLog::end_silence(StreamEventKind kind, drivers::TimePoint now) {
  Silence& silence = silences_[static_cast<std::size_t>(kind)];
  if (!silence.begun || now < silence.end) return;
  const Silence ended = silence;
  silence = {.begun = ended.events > 0, .end = now + kQuiet};
  if (ended.events == 0) return;
  say_(level_of({.kind = kind}), "stream: " + sum_line(kind, ended.events, ended.values));
}

}  // namespace truepose::daemon
