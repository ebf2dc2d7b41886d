#include <algorithm>

#include "core/formatted.hpp"
#include "drivers/bridge/bridge_tracker.hpp"
#include "drivers/plausible_point.hpp"
#include "tools/truepose/bridge/examination.hpp"

namespace truepose::tools {

using namespace std::chrono_literals;
using bridge::ErrorCode, bridge::EventKind;

namespace {

constexpr drivers::Duration kMotion = 60s;
constexpr drivers::Duration kInitialise = 120s;

}  // namespace

Trial Examination::initialises() {
  if (!options_.reflector_mm) co_return Seen::not_tried("it moves the tracker: give --at X,Y,Z");
  bridge::Initialise request;
  const auto done = co_await line_.ask(request, kInitialise);
  if (!done) co_return Seen::otherwise(done.error());
  bridge::GetStatus ask_status;
  const auto status = co_await line_.ask(ask_status, kBridgeLookUp);
  if (!status) co_return Seen::otherwise(status.error());
  if (!status->initialised) co_return Seen::otherwise("the status says that it is not initialised");
  initialised_ = true;
  co_return Seen::kept();
}

BridgeTask<void> Examination::aim_at(Eigen::Vector3d p_mm, double search_mm,
                                     std::chrono::milliseconds timeout) {
  bridge::DoAim request{p_mm, search_mm, timeout};
  const auto aimed = co_await line_.ask(request, kMotion);
  if (!aimed) co_return std::unexpected(aimed.error());
  co_return std::expected<void, std::string>{};
}

Trial Examination::aims() {
  if (!initialised_) co_return Seen::not_tried("the tracker is not initialised");
  const auto aimed = co_await aim_at(*options_.reflector_mm, options_.search_mm, 10s);
  if (!aimed) co_return Seen::otherwise(aimed.error());
  bridge::GetStatus ask_status;
  const auto status = co_await line_.ask(ask_status, kBridgeLookUp);
  if (!status) co_return Seen::otherwise(status.error());
  if (!status->locked) co_return Seen::otherwise("the status says that no reflector is locked");
  if (status->face == 2) co_return Seen::otherwise("the tracker is in face 2");
  aimed_ = true;
  co_return Seen::kept();
}

Trial Examination::misses() {
  if (!aimed_) co_return Seen::not_tried("no reflector was found before");
  const Eigen::Vector3d off_target_mm = *options_.reflector_mm + Eigen::Vector3d{0, 0, 500};
  bridge::DoAim request{off_target_mm, 5, 2s};
  const auto id = co_await line_.send_request(request);
  if (!id) co_return Seen::otherwise(id.error());
  const auto reply = co_await line_.reply_to(*id, kMotion);
  const Seen seen = expect_refusal(reply, ErrorCode::NoTarget, *id);
  const auto back = co_await aim_at(*options_.reflector_mm, options_.search_mm, 10s);
  if (!seen.fault.empty()) co_return seen;
  co_return kept_where(back);
}

Trial Examination::measures() {
  if (!aimed_) co_return Seen::not_tried("no reflector was found before");
  bridge::DoMeasure request{options_.measure};
  const auto result = co_await line_.ask(request, options_.measure + kMotion);
  if (!result) co_return Seen::otherwise(result.error());
  const double off_mm = (result->p_W_mm - *options_.reflector_mm).norm();
  if (off_mm > options_.search_mm)
    co_return Seen::otherwise(
        formatted("the point is %.1f mm from where it was to look: units, axes, frame?", off_mm));
  if (result->averaged < options_.measure)
    co_return Seen::otherwise("averaged_ms is less than time_ms asked for");
  if (result->age > 1s) co_return Seen::otherwise("age_ms says that the point is an old one");
  if (const auto why_not = drivers::implausible(drivers::point_of(*result)))
    co_return Seen::otherwise(*why_not);
  co_return Seen::kept();
}

Trial Examination::lives_while_it_measures() {
  if (!aimed_) co_return Seen::not_tried("no reflector was found before");
  bridge::DoMeasure request{2 * options_.measure};
  const auto measuring = co_await line_.send_request(request);
  if (!measuring) co_return Seen::otherwise(measuring.error());
  bridge::Ping ping;
  const auto pinged = co_await line_.send_request(ping);
  if (!pinged) co_return Seen::otherwise(pinged.error());
  const auto alive = co_await line_.reply_to(*pinged, kAtOnce);
  if (!alive) co_return Seen::otherwise(alive.error());
  const auto measured = co_await line_.reply_to(*measuring, 2 * options_.measure + kMotion);
  co_return kept_where(measured);
}

Trial Examination::is_busy_while_it_measures() {
  if (!aimed_) co_return Seen::not_tried("no reflector was found before");
  bridge::DoMeasure request{2 * options_.measure};
  const auto measuring = co_await line_.send_request(request);
  if (!measuring) co_return Seen::otherwise(measuring.error());
  const auto second = co_await line_.send_request(request);
  if (!second) co_return Seen::otherwise(second.error());
  const auto refused = co_await line_.reply_to(*second, kBridgeLookUp);
  const Seen seen = expect_refusal(refused, ErrorCode::Busy, *second);
  if (!seen.fault.empty()) co_return seen;
  const auto measured = co_await line_.reply_to(*measuring, 2 * options_.measure + kMotion);
  co_return kept_where(measured);
}

Trial Examination::stops() {
  if (!aimed_) co_return Seen::not_tried("no reflector was found before");
  bridge::DoMeasure request{10 * options_.measure};
  const auto measuring = co_await line_.send_request(request);
  if (!measuring) co_return Seen::otherwise(measuring.error());
  bridge::Stop stop;
  const auto stopping = co_await line_.send_request(stop);
  if (!stopping) co_return Seen::otherwise(stopping.error());
  const auto ended = co_await line_.reply_to(*measuring, kBridgeLookUp);
  const Seen seen = expect_refusal(ended, ErrorCode::Stopped, *measuring);
  if (!seen.fault.empty()) co_return seen;
  const auto stopped = co_await line_.reply_to(*stopping, kBridgeLookUp);
  co_return kept_where(stopped);
}

Trial Examination::turns_over() {
  if (!aimed_) co_return Seen::not_tried("no reflector was found before");
  for (const int face : {2, 1}) {
    bridge::SetFace request{face};
    const auto id = co_await line_.send_request(request);
    if (!id) co_return Seen::otherwise(id.error());
    const auto reply = co_await line_.reply_to(*id, kMotion);
    if (!reply) co_return Seen::otherwise(reply.error());
    if (face == 2 && !reply->outcome && reply->outcome.error().meaning() == ErrorCode::NotOffered)
      co_return Seen::not_tried("the bridge does not offer it: " + reply->outcome.error().text);
    const auto turned = BridgeLine::answer_in<bridge::SetFace>(*reply);
    if (!turned) co_return Seen::otherwise(turned.error());
    bridge::GetStatus ask_status;
    const auto status = co_await line_.ask(ask_status, kBridgeLookUp);
    if (!status) co_return Seen::otherwise(status.error());
    if (status->face != face)
      co_return Seen::otherwise(
          formatted("the status says face %d after %d was asked for", status->face, face));
    if (!status->locked) co_return Seen::otherwise("no reflector is locked from the other face");
  }
  co_return Seen::kept();
}

Trial Examination::loses_beam() {
  if (!aimed_) co_return Seen::not_tried("no reflector was found before");
  if (std::ranges::find(greeting_.rehearses, bridge::Rehearsal::BeamBreak) == greeting_.rehearses.end())
    co_return Seen::not_tried("the bridge does not offer to rehearse it: break the beam by hand");
  line_.events.clear();
  bridge::DoMeasure request{10 * options_.measure};
  const auto measuring = co_await line_.send_request(request);
  if (!measuring) co_return Seen::otherwise(measuring.error());
  bridge::Rehearse rehearse{.lasts = 300ms};
  const auto breaking = co_await line_.send_request(rehearse);
  if (!breaking) co_return Seen::otherwise(breaking.error());
  bool broken = false, answered = false;
  for (int replies = 0; replies < 2; ++replies) {
    const auto reply = co_await line_.next_reply(kBridgeLookUp);
    if (!reply) co_return Seen::otherwise(reply.error());
    answered = answered || reply->id == *breaking;
    if (reply->id != *measuring) continue;
    const Seen seen = expect_refusal(reply, ErrorCode::BeamBroken, *measuring);
    if (!seen.fault.empty()) co_return seen;
    broken = true;
  }
  if (!broken || !answered) co_return Seen::otherwise("not every request was answered");
  if (!line_.has_seen(EventKind::BeamLost)) co_return Seen::otherwise("no event beam-lost came");
  const drivers::TimePoint back = clock_.now() + rehearse.lasts + 200ms;
  co_await clock_.sleep_until(back);
  const auto found = co_await aim_at(*options_.reflector_mm, options_.search_mm, 10s);
  co_return kept_where(found);
}

Trial Examination::comes_back() {
  line_.close();
  const drivers::TimePoint again = clock_.now() + 200ms;
  co_await clock_.sleep_until(again);
  const auto back = co_await reconnect();
  if (!back) co_return Seen::otherwise(back.error());
  const Seen alive = co_await lives();
  co_return alive;
}

}  // namespace truepose::tools
