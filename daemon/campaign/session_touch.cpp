// Points that the arm's TCP touches, jogged there by hand.

#include <utility>

#include "daemon/campaign/measuring_session.hpp"

namespace truepose::daemon {

CampaignOutcome<void> MeasuringSession::touch(Touch what) {
  if (past_) {
    const auto before = touched_before(what);
    if (!before) co_return std::unexpected(before.error());
    if (*before) co_return Done{};
    Done resumed = co_await resume_from_past();
    if (!resumed) co_return resumed;
  }
  StoredPoint point;
  point.pose = what.number;
  point.purpose = PointPurpose::Frame;
  point.smr = what.point;
  for (std::string sentence = what.request;;) {
    co_await wait_for_operator(sentence);
    auto q = co_await jogged_to();
    if (q) {
      point.q_actual = *std::move(q);
      break;
    }
    sentence = q.error().detail + ": " + what.request;
  }
  auto stored = co_await store(std::move(point));
  if (!stored) co_return std::unexpected(stored.error());
  progress().count_done();
  observer().on_point(*stored, 0, progress().now());
  co_return Done{};
}

/// Who resumes twice has not touched twice.
CellDevices::Outcome<JointVector> MeasuringSession::jogged_to() {
  auto q = co_await devices_.standstill();
  if (!q || result().points.empty()) co_return q;
  const StoredPoint& before = result().points.back();
  if (!CellDevices::has_stayed(*q, before.q_actual)) co_return q;
  co_return std::unexpected(DeviceError{
      Remedy::Retry, "robot: the arm has not been moved since it touched point \"" + before.smr + "\""});
}

}  // namespace truepose::daemon
