#include "daemon/realtime/stream_log.hpp"

#include <array>
#include <cstdio>

namespace truepose::daemon {
namespace {

std::string counted(std::uint64_t count, const std::string& singular, const std::string& plural) {
  return std::to_string(count) + ' ' + (count == 1 ? singular : plural);
}

std::string degrees(std::uint64_t microdegrees) {
  std::array<char, 32> text;
  std::snprintf(text.data(), text.size(), "%.3f deg", static_cast<double>(microdegrees) * 1e-6);
  return text.data();
}

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

std::string describe(const StreamEvent& event) {
  const std::string at = " at IPOC " + std::to_string(event.ipoc);
  switch (event.kind) {
    case StreamEventKind::SessionStarted:
      return "the controller began a session at IPOC " + std::to_string(event.value) + " from " +
             text(event.source);
    case StreamEventKind::SessionProven:
      return "the correction that the controller has in force is known" + at + ": at most " +
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
      return event.value == 0 ? "no model is in force" : "another model is in force";
    case StreamEventKind::Foreign:
      return "packets of " + text(event.source) +
             " are dropped: the controller is expected at robot.rsi_peer (left out: the host of "
             "robot.eki_motion) and at the port that its session began with; if this is its address in the "
             "RSI network, give it as robot.rsi_peer, else stop that sender";
    case StreamEventKind::Disarmed:
      return "the controller was silent for " + std::to_string(event.value) +
             " ms: the correction is ramped out until the stream is started anew";
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
         "stream: " + counted(dropped - dropped_, "event", "events") + " came too fast to be told");
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
