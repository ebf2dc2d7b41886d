// How a campaign continues that was interrupted.

#include <functional>
#include <utility>

#include "core/math/units.hpp"
#include "daemon/campaign/interruption_check.hpp"
#include "daemon/campaign/measuring_session.hpp"

namespace truepose::daemon {

namespace {

namespace asio = boost::asio;
CampaignError not_its_own(const std::string& what) {
  return {CampaignFault::Internal, "what is stored of the campaign does not follow from its plan: " + what +
                                       " (another version, or another robot file?)"};
}

}  // namespace

void MeasuringSession::begin_resumption(const std::string& time) {
  result().resumptions = past_->resumptions;
  Resumption resumption{{past_->record.ended, time, {}}};
  if (!past_->resumptions.empty()) resumption.X_first_now = past_->resumptions.back().X_first_now;
  search_.set_tracker_shift(resumption.X_first_now.inverse());
  result().resumptions.push_back(std::move(resumption));
}

std::optional<CampaignError> MeasuringSession::other_arm() {
  if (!past_) return std::nullopt;
  const std::string &begun = past_->record.robot_serial, &here = result().identities.robot.serial;
  if (begun.empty() || begun == here) return std::nullopt;
  return CampaignError{.fault = CampaignFault::WrongArm,
                       .detail = "another arm: the campaign was begun with serial number " + begun +
                                 ", the controller says " + here,
                       .what_to_do = "connect the arm of the campaign, or abort it"};
}

Eigen::Vector3d MeasuringSession::now(const Eigen::Vector3d& p_mm) {
  if (result().resumptions.empty()) return p_mm;
  return result().resumptions.back().X_first_now.inverse() * p_mm;
}

std::optional<CampaignError> MeasuringSession::contradiction(const MeasuringTarget& target) const {
  const PlannedPose* const planned = past_->planned(target.pose);
  const std::string pose = "pose " + std::to_string(target.pose);
  if (planned && (planned->purpose != target.purpose || planned->q_target != target.q_target))
    return not_its_own(pose + " is another");
  const bool to_come = !past_->skipped_pose(target.pose) && !past_->point(target.pose, target.purpose);
  if (to_come && !has_resumed_ && past_left_ > 0)
    return not_its_own(pose + " was not measured, but " + std::to_string(past_left_) + " later ones");
  return std::nullopt;
}

/// A pose of which not all reflectors had been stored is taken with those that were.
std::optional<StoredPoint> MeasuringSession::measured_before(int number, PointPurpose purpose,
                                                             std::string_view smr) {
  std::optional<StoredPoint> first;
  for (const StoredPoint* const point : past_->points_of(number, purpose, smr)) {
    const StoredPoint* const face1 = past_->point(number, PointPurpose::Face1, point->smr);
    if (face1 && is_pose(purpose)) result().points.push_back(*face1);
    result().points.push_back(*point);
    --past_left_;
    if (!first) first = in_first_frame(*point);
  }
  return first;
}

std::expected<bool, CampaignError> MeasuringSession::touched_before(const Touch& what) {
  if (measured_before(what.number, PointPurpose::Frame, what.point)) {
    progress().count_done();
    return true;
  }
  if (past_left_ == 0) return false;
  return std::unexpected(
      not_its_own("touch " + std::to_string(what.number) + " was not of point \"" + what.point + "\""));
}

bool MeasuringSession::skipped_before(int number) {
  const SkippedPose* const skipped = past_ ? past_->skipped_pose(number) : nullptr;
  if (!skipped) return false;
  result().skipped.push_back(*skipped);
  progress().count_skipped();
  --past_left_;
  return true;
}

std::optional<MeasuringSession::Before> MeasuringSession::taken_before(const MeasuringTarget& target) {
  const std::size_t taken = result().points.size();
  if (const auto point = measured_before(target.pose, target.purpose)) {
    progress().count_done();
    for (std::size_t i = taken; i < result().points.size(); ++i)
      if (is_pose(result().points[i].purpose)) count_deviation(result().points[i]);
    return Before{point};
  }
  if (skipped_before(target.pose)) return Before{};
  return std::nullopt;
}

/// Before the first step that was not taken yet.
CampaignOutcome<void> MeasuringSession::resume_from_past() {
  if (has_resumed_) co_return Done{};
  const CampaignPhase phase = progress().counted().phase;
  if (before_resuming_) {
    Done done = co_await before_resuming_();
    if (!done) co_return done;
  }
  auto since = co_await find_what_moved(*this);
  if (!since) co_return std::unexpected(since.error());
  Resumption& resumption = result().resumptions.back();
  resumption.found = since->found;
  resumption.X_first_now = since->X_first_now;
  search_.set_tracker_shift(resumption.X_first_now.inverse());
  Done noted = co_await note_resumption();
  if (!noted) co_return noted;
  progress().enter(phase);
  co_return Done{};
}

CampaignOutcome<void> MeasuringSession::note_resumption() {
  if (!past_ || has_resumed_) co_return Done{};
  Resumption& resumption = result().resumptions.back();
  if (resumption.found.empty()) resumption.found = "all had been measured";
  Done kept = co_await write(&CampaignJournal::add_resumption, resumption);
  if (!kept) co_return kept;
  has_resumed_ = true;
  progress().end_past();
  observer().on_trouble(described(resumption));
  co_return Done{};
}

CampaignOutcome<std::optional<Eigen::Vector3d>> MeasuringSession::measure_again(StoredPoint before,
                                                                                Eigen::Vector3d p_W_mm) {
  const bool is_nest = before.purpose == PointPurpose::Nest;
  const config::CampaignConfig& campaign = config().campaign;
  MeasuringTarget target{.pose = before.pose,
                         .purpose = PointPurpose::Check,
                         .q_target = before.q_target,
                         .q_commanded = before.q_commanded,
                         .way_rad = before.purpose == PointPurpose::Reference
                                        ? campaign.approach_deg * kRadPerDeg
                                        : approach_way_rad(campaign, before.pose),
                         .q_from = {}};
  const double search_mm = is_nest ? config().tracker.first_search_radius_mm : search_.clear_radius_mm();
  CellDevices::MeasureRequest request{.p_W_mm = p_W_mm,
                                      .search_mm = search_mm,
                                      .gate_mm = search_mm,
                                      .two_face = !is_nest && in_two_faces(before.pose)};
  for (int n = 0; n <= campaign.retries; ++n) {
    co_await pause().wait();
    auto seen = co_await attempt_again(target, request, before.smr, is_nest);
    if (seen) {
      seen->pose = before.pose;
      seen->purpose = PointPurpose::Check;
      seen->smr = before.smr;
      auto stored = co_await store(*std::move(seen));
      if (!stored) co_return std::unexpected(stored.error());
      co_return *stored->p_WS_mm;
    }
    observer().on_trouble((is_nest ? before.smr : "pose " + std::to_string(before.pose)) +
                          ", measured again: " + seen.error().detail);
    Done recovered = co_await recover(seen.error());
    if (!recovered) co_return std::unexpected(recovered.error());
  }
  co_return std::nullopt;
}

CellDevices::Outcome<StoredPoint> MeasuringSession::attempt_again(MeasuringTarget target,
                                                                  CellDevices::MeasureRequest request,
                                                                  std::string smr, bool is_nest) {
  if (is_nest) {
    auto nest = co_await attempt_fixed(request);
    co_return nest;
  }
  auto reached = co_await reach(target);
  if (!reached) co_return std::unexpected(reached.error());
  auto measured = co_await devices_.measure(request);
  if (!measured) co_return std::unexpected(measured.error());
  co_return point_at(target, *reached, measured->point, smr);
}

CampaignOutcome<void> MeasuringSession::keep_identified(std::string sha256) {
  if (past_ && !past_->plan.identified.empty()) {
    if (past_->plan.identified != sha256)
      observer().on_trouble(
          "the identification, made again from the same points, differs in its last digits: it was made by "
          "another version or on another processor");
    co_return Done{};
  }
  Done kept = co_await write(&CampaignJournal::add_identified, sha256);
  co_return kept;
}

}  // namespace truepose::daemon
