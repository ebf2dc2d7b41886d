#include "daemon/campaign/session_plan.hpp"

#include <utility>

#include "config/cell_setup.hpp"

namespace truepose::daemon {

SessionPlan::SessionPlan(CampaignRun& run, SessionDevices& devices, std::shared_ptr<const CampaignPast> past)
    : run_{run}, devices_{devices}, past_{std::move(past)} {
  if (!past_) return;
  for (const PlannedPose& planned : past_->plan.poses) in_journal_.insert(planned.pose);
}

CampaignOutcome<void> SessionPlan::choose(CalibratedCell cell, PlanOptions options, Reflectors reflectors) {
  run_.progress().enter(CampaignPhase::Plan);
  options.sizes.clear();
  options.random_sets = 0;
  auto here = co_await devices_.cell().position();
  if (here) options.start = *here;
  Scene scene = config::scene_of(run_.config());
  scene.shows_last_axis = !options.by_orientation;
  if (reflectors == Reflectors::First) scene.sight.further.clear();
  devices_.search().look_for(reflectors);
  const auto earlier = past_ ? past_->earlier_plan() : std::nullopt;
  auto job = [cell, scene, options, earlier] {
    return earlier ? PoseSupply::again(cell, scene, options, *earlier)
                   : PoseSupply::make(cell, scene, options);
  };
  auto made = co_await run_.compute(job);
  if (!made) co_return std::unexpected(CampaignError{CampaignFault::Planning, made.error()});
  poses_ = std::make_shared<PoseSupply>(*std::move(made));
  devices_.motion().use_paths_of(poses_);
  co_return Done{};
}

MeasuringTarget SessionPlan::new_target(PointPurpose purpose, const JointVector& q, Replacement replacement) {
  const int pose = next_number();
  return {.pose = pose,
          .purpose = purpose,
          .q_target = q,
          .q_commanded = q,
          .replacement = replacement,
          .way_rad = approach_way_rad(run_.config().campaign, pose)};
}

CampaignOutcome<void> SessionPlan::keep(std::vector<MeasuringTarget> targets) {
  std::vector<PlannedPose> fresh;
  for (const MeasuringTarget& target : targets)
    if (in_journal_.insert(target.pose).second)
      fresh.push_back({target.pose, target.purpose, target.q_target, target.q_commanded, target.replaces});
  if (fresh.empty()) co_return Done{};
  co_return co_await run_.write(&CampaignJournal::add_planned, fresh, run_.progress().counted().total);
}

CampaignOutcome<std::optional<MeasuringTarget>> SessionPlan::substitute(MeasuringTarget failed) {
  if (failed.replacement == Replacement::None || substitutes_ >= run_.progress().counted().done)
    co_return std::nullopt;
  const PlannedPose* const before = past_ ? past_->substitute_of(failed.pose) : nullptr;
  std::optional<JointVector> q;
  if (before) {
    q = before->q_target;
    poses_->replaced(failed.q_target, *q);
  } else {
    const bool informative = failed.replacement == Replacement::Informative;
    auto job = [poses = poses_, q_failed = failed.q_target, informative] {
      return informative ? poses->substitute(q_failed) : poses->validation_substitute(q_failed);
    };
    q = co_await run_.compute(job);
  }
  if (!q) co_return std::nullopt;
  ++substitutes_;
  run_.progress().add_to_total(1);
  MeasuringTarget target = new_target(failed.purpose, *q, failed.replacement);
  target.replaces = failed.pose;
  if (!before)
    run_.observer().on_trouble("pose " + std::to_string(failed.pose) + " is replaced by pose " +
                               std::to_string(target.pose));
  co_return target;
}

}  // namespace truepose::daemon
