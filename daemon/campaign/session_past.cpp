#include "daemon/campaign/session_past.hpp"

#include <utility>

#include "core/planted_bug.hpp"

namespace truepose::daemon {

namespace {

CampaignError not_its_own(const std::string& what) {
  return {CampaignFault::Internal, "what is stored of the campaign does not follow from its plan: " + what +
                                       " (another version, or another robot file?)"};
}

}  // namespace

SessionPast::SessionPast(CampaignRun& run, std::shared_ptr<const CampaignPast> past)
    : run_{run}, past_{std::move(past)}, left_{past_ ? past_->outcomes() : 0} {}

void SessionPast::begin(const std::string& time) {
  if (!past_) return;
  std::vector<Resumption>& resumptions = run_.result().resumptions;
  resumptions = past_->resumptions;
  Resumption resumption{{past_->record.ended, time, {}}};
  if (!resumptions.empty()) resumption.X_first_now = resumptions.back().X_first_now;
  resumptions.push_back(std::move(resumption));
}

Done SessionPast::check_arm() const {
  if (!past_) return {};
  const std::string &begun = past_->record.robot_serial, &here = run_.result().identities.robot.serial;
  if (begun.empty() || begun == here) return {};
  return std::unexpected(CampaignError{.fault = CampaignFault::WrongArm,
                                       .detail = "another arm: the campaign was begun with serial number " +
                                                 begun + ", the controller says " + here,
                                       .what_to_do = "connect the arm of the campaign, or abort it"});
}

CampaignOutcome<void> SessionPast::note_resumption() {
  if (!past_ || has_resumed_) co_return Done{};
  Resumption& resumption = run_.result().resumptions.back();
  if (resumption.found.empty()) resumption.found = "all had been measured";
  Done kept = co_await run_.write(&CampaignJournal::add_resumption, resumption);
  if (!kept) co_return kept;
  has_resumed_ = true;
  run_.progress().end_past();
  run_.observer().on_trouble(described(resumption));
  co_return Done{};
}

std::expected<std::optional<SessionPast::Points>, CampaignError> SessionPast::take(
    const MeasuringTarget& target) {
  if (!past_ || planted("a resumed campaign measures all again")) return std::nullopt;
  if (const auto wrong = contradiction(target)) return std::unexpected(*wrong);
  const Points points = take_points(target.pose, target.purpose);
  if (points.empty() && !take_skipped(target.pose)) return std::nullopt;
  if (!points.empty()) run_.progress().count_done();
  return points;
}

/// Why the past does not follow from the plan.
std::optional<CampaignError> SessionPast::contradiction(const MeasuringTarget& target) const {
  const PlannedPose* const planned = past_->planned(target.pose);
  const std::string pose = "pose " + std::to_string(target.pose);
  if (planned && (planned->purpose != target.purpose || planned->q_target != target.q_target))
    return not_its_own(pose + " is another");
  const bool to_come = !past_->skipped_pose(target.pose) && !past_->point(target.pose, target.purpose);
  if (to_come && !has_resumed_ && has_more())
    return not_its_own(pose + " was not measured, but " + std::to_string(left_) + " later ones");
  return std::nullopt;
}

SessionPast::Points SessionPast::take_points(int number, PointPurpose purpose, std::string_view smr) {
  Points taken;
  if (!past_) return taken;
  Points& points = run_.result().points;
  for (const StoredPoint* const point : past_->points_of(number, purpose, smr)) {
    const StoredPoint* const face1 = past_->point(number, PointPurpose::Face1, point->smr);
    if (face1 && is_pose(purpose)) points.push_back(*face1);
    points.push_back(*point);
    taken.push_back(*point);
    --left_;
  }
  return taken;
}

std::expected<bool, CampaignError> SessionPast::take_touch(int number, const std::string& point) {
  if (!take_points(number, PointPurpose::Frame, point).empty()) {
    run_.progress().count_done();
    return true;
  }
  if (!has_more()) return false;
  return std::unexpected(
      not_its_own("touch " + std::to_string(number) + " was not of point \"" + point + "\""));
}

bool SessionPast::take_skipped(int pose) {
  const SkippedPose* const skipped = past_ ? past_->skipped_pose(pose) : nullptr;
  if (!skipped) return false;
  run_.result().skipped.push_back(*skipped);
  run_.progress().count_skipped();
  --left_;
  return true;
}

JointVector SessionPast::commanded(const MeasuringTarget& target) const {
  const PlannedPose* const planned = past_ ? past_->planned(target.pose) : nullptr;
  return planned && target.purpose == PointPurpose::Remeasure ? planned->q_commanded : target.q_commanded;
}

CampaignOutcome<void> SessionPast::keep_identified(std::string sha256) {
  if (!past_ || past_->plan.identified.empty())
    co_return co_await run_.write(&CampaignJournal::add_identified, sha256);
  if (past_->plan.identified != sha256)
    run_.observer().on_trouble(
        "the identification, made again from the same points, differs in its last digits: it was made by "
        "another version or on another processor");
  co_return Done{};
}

}  // namespace truepose::daemon
