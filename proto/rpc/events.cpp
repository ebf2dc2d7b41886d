#include "proto/rpc/events.hpp"

#include <set>

namespace truepose::rpc {

using record::OneOf;

void layout(Io& io, EventsSubscribe::Result::Missing& x) {
  io.about("Number")("first", x.first);
  io.about("Number, included")("last", x.last);
  io.about("One phrase")("reason", x.reason);
}
void layout(Io& io, EventsSubscribe::Result& x) {
  io("topics", x.topics, control::kTopics);
  io.about("Number of the next new event")("next", x.next);
  io.about("Number from which on every event is there, those too that are kept for a while alone")("oldest",
                                                                                                   x.oldest);
  io.about("Nothing is missing since `after` of what is kept; true without it")("complete", x.complete);
  io.about(
      "Ranges after `after`, in order, in which kept events may be missing. Causes: older than 90 "
      "days, lost when the daemon was killed or the power failed, or the store could not be written. "
      "Not every number in them was an event")("missing", x.missing);
}
void layout(Io& io, EventsSubscribe& x) {
  io.about("Default: all").optional("topics", x.topics, control::kTopics);
  io.about(
        "Number of the last event seen: what followed and is kept is sent first, in order. 0: all that "
        "is kept")
      .optional("after", x.after);
}
void check(const Io& io, const EventsSubscribe& x) {
  if (!x.topics) return;
  const std::set<control::Topic> distinct{x.topics->begin(), x.topics->end()};
  if (distinct.size() != x.topics->size()) io.fail_at("topics", "expected distinct topics");
}
const Method& EventsSubscribe::method() {
  static const Method kMethod{
      .name = "events.subscribe",
      .summary = "Sends events from now on, after those that were missed",
      .description =
          "Replaces an earlier subscription of this connection. A client that reads too slowly is "
          "disconnected. Events of cell, campaign, measurement, model, fault and control are kept for 90 "
          "days, over restarts of the daemon. So are changes of state of stream and robot, and warnings "
          "and errors of the log. The stream's events once a second and information in the log are kept "
          "among the last 4096 events alone.",
  };
  return kMethod;
}

void layout(Io& io, EventsUnsubscribe::Result& x) { io.about("Empty")("topics", x.topics, control::kTopics); }
const Method& EventsUnsubscribe::method() {
  static const Method kMethod{
      .name = "events.unsubscribe",
      .summary = "Sends no more events",
  };
  return kMethod;
}

void layout(Io& io, StateChanged& x) {
  io.about("What the cell does")(
      "state", x.state,
      OneOf{"disconnected", "connecting", "ready", "campaign", "paused", "streaming", "armed", "fault"});
  io.about("The state before")("from", x.from);
  io.about("One sentence")("reason", x.reason);
  io.about("The client that caused it; null: the daemon itself").nullable("by", x.by);
}

void layout(Io& io, PointMeasured& x) {
  io.about("The campaign").format("uuid")("campaign_id", x.campaign_id);
  layout(io, static_cast<SeenPoint&>(x));
  io.about("Distance from the prediction; null before the first fit").nullable("error_mm", x.error_mm);
  io.about("Why it was skipped, else empty")("reason", x.reason);
}

void layout(Io& io, ModelChanged& x) {
  io.about("The client that caused it; null: the daemon itself").nullable("by", x.by);
  io("change", x.change, OneOf{"made", "activated", "deactivated"});
  io("model", x.model);
}

void layout(Io& io, FaultChanged& x) {
  layout_members(io, x.fault);
  io.about("false: it went")("active", x.active);
}

void layout(Io& io, LogLine& x) {
  io("level", x.level, OneOf{"info", "warning", "error"});
  io("text", x.text);
}

void layout(Io& io, ControlChanged& x) {
  io("change", x.change, OneOf{"command", "acquired", "released", "taken-over", "lost"});
  io.about("Who did, or lost it")("by", x.by);
  io.about("From whom control was taken").optional("from", x.from);
  io.about("Of a command").optional("method", x.method);
  io.about("Of a command: ok, or the error's code").optional("result", x.result);
}

std::vector<Described> events_methods() {
  return {described<EventsSubscribe>(), described<EventsUnsubscribe>()};
}

}  // namespace truepose::rpc
