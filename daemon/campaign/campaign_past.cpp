#include "daemon/campaign/campaign_past.hpp"

#include <algorithm>
#include <set>
#include <utility>

#include "config/cell_setup.hpp"
#include "core/plan/scene.hpp"

namespace truepose::daemon {

namespace {

/// Those that were planned at first, without what came up on the way.
std::vector<JointVector> planned_to(const CampaignPlan& plan, PointPurpose purpose) {
  std::vector<JointVector> poses;
  for (const PlannedPose& planned : plan.poses) {
    // Rounds at a target are of one pose, and so is what a reflector shows that is put elsewhere.
    const bool several = purpose == PointPurpose::Target || purpose == PointPurpose::Frame;
    const bool again = several && std::ranges::find(poses, planned.q_target) != poses.end();
    if (planned.purpose == purpose && planned.replaces == 0 && !again) poses.push_back(planned.q_target);
  }
  return poses;
}

std::string pose_name(int pose) { return "pose " + std::to_string(pose) + " of the plan"; }

}  // namespace

const StoredPoint* CampaignPast::point(int pose, PointPurpose purpose, std::string_view smr) const {
  // The last one: a point that was stored without what belongs to it is measured once more.
  const auto found = points_of(pose, purpose, smr);
  return found.empty() ? nullptr : found.back();
}

std::vector<const StoredPoint*> CampaignPast::points_of(int pose, PointPurpose purpose,
                                                        std::string_view smr) const {
  std::vector<const StoredPoint*> found;
  for (const StoredPoint& point : points)
    if (point.pose == pose && point.purpose == purpose && (smr.empty() || point.smr == smr))
      found.push_back(&point);
  return found;
}

const SkippedPose* CampaignPast::skipped_pose(int pose) const {
  const auto found = std::ranges::find(skipped, pose, &SkippedPose::pose);
  return found == skipped.end() ? nullptr : &*found;
}

const PlannedPose* CampaignPast::planned(int pose) const {
  const auto found = std::ranges::find(plan.poses, pose, &PlannedPose::pose);
  return found == plan.poses.end() ? nullptr : &*found;
}

const PlannedPose* CampaignPast::substitute_of(int pose) const {
  const auto found = std::ranges::find(plan.poses, pose, &PlannedPose::replaces);
  return found == plan.poses.end() ? nullptr : &*found;
}

int CampaignPast::poses_done() const {
  std::set<std::pair<int, PointPurpose>> poses;
  for (const StoredPoint& point : points)
    if (is_pose(point.purpose)) poses.emplace(point.pose, point.purpose);
  return static_cast<int>(poses.size());
}

std::size_t CampaignPast::outcomes() const {
  return skipped.size() +
         static_cast<std::size_t>(std::ranges::count_if(points, [](const StoredPoint& point) {
           return is_pose(point.purpose) || point.purpose == PointPurpose::Nest;
         }));
}

std::optional<EarlierPlan> CampaignPast::earlier_plan() const {
  if (plan.poses.empty()) return std::nullopt;
  EarlierPlan earlier{planned_to(plan, PointPurpose::Identify), planned_to(plan, PointPurpose::Validate), {}};
  if (earlier.poses.empty()) earlier.poses = planned_to(plan, PointPurpose::Frame);
  if (earlier.validate.empty()) earlier.validate = planned_to(plan, PointPurpose::Target);
  const auto references = planned_to(plan, PointPurpose::Reference);
  if (!references.empty()) earlier.reference = references.front();
  return earlier;
}

std::optional<std::string> CampaignPast::misfit(const config::CellConfig& config) const {
  const RobotModel& robot = config.robot.model;
  for (const PlannedPose& planned : plan.poses)
    if (planned.q_target.size() != robot.joint_count())
      return pose_name(planned.pose) + " has " + std::to_string(planned.q_target.size()) + " joints, " +
             robot.name + " has " + std::to_string(robot.joint_count());
  const std::vector<config::ReflectorConfig> reflectors = config::reflectors_of(config);
  for (const StoredPoint& point : points) {
    const auto known = std::ranges::find(reflectors, point.smr, &config::ReflectorConfig::name);
    if (!is_pose(point.purpose) || !point.p_WS_mm || known != reflectors.end()) continue;
    std::string names;
    for (const config::ReflectorConfig& reflector : reflectors)
      names += (names.empty() ? "'" : ", '") + reflector.name + "'";
    return "reflector '" + point.smr + "' was measured, the cell file has " + names;
  }
  if (config.tracker.nests_mm.size() != static_cast<std::size_t>(nests))
    return "the cell had " + std::to_string(nests) + " nests, the cell file has " +
           std::to_string(config.tracker.nests_mm.size());

  PoseChecker checker{config::scene_of(config)};
  for (const PlannedPose& planned : plan.poses) {
    const bool chosen_by_plan =
        planned.purpose == PointPurpose::Identify || planned.purpose == PointPurpose::Validate ||
        planned.purpose == PointPurpose::Reference || planned.purpose == PointPurpose::Frame;
    if (!chosen_by_plan || skipped_pose(planned.pose) || point(planned.pose, planned.purpose)) continue;
    if (const auto fault = checker.fault_of(planned.q_target))
      return pose_name(planned.pose) + " " + std::string{fault_text(*fault)};
  }
  return std::nullopt;
}

StoreResult<CampaignPast> read_past(Store& store, const std::string& campaign_id) {
  auto record = store.campaign(campaign_id);
  if (!record) return std::unexpected(record.error());
  auto plan = store.plans().plan(campaign_id);
  if (!plan) return std::unexpected(plan.error());
  auto points = store.points(campaign_id);
  if (!points) return std::unexpected(points.error());
  auto skipped = store.skipped(campaign_id);
  if (!skipped) return std::unexpected(skipped.error());
  auto resumptions = store.plans().resumptions(campaign_id);
  if (!resumptions) return std::unexpected(resumptions.error());
  if (!*record || !*plan) return std::unexpected(StoreError{"campaign " + campaign_id + " has no plan"});
  return CampaignPast{**std::move(record), **std::move(plan),       *std::move(points),
                      *std::move(skipped), *std::move(resumptions), {}};
}

std::string described(const Resumption& resumption) {
  return "the campaign was interrupted (" + resumption.interrupted + ") and resumed (" + resumption.resumed +
         ")" + (resumption.found.empty() ? "" : ": " + resumption.found);
}

StoredPoint in_first_frame(StoredPoint point, const std::vector<Resumption>& resumptions) {
  if (point.p_WS_mm && point.resumption > 0 &&
      static_cast<std::size_t>(point.resumption) <= resumptions.size())
    point.transform(resumptions[static_cast<std::size_t>(point.resumption) - 1].X_first_now);
  return point;
}

}  // namespace truepose::daemon
