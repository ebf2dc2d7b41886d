#pragma once

#include <memory>
#include <optional>
#include <set>
#include <vector>

#include "core/plan/pose_supply.hpp"
#include "daemon/campaign/session_devices.hpp"

namespace truepose::daemon {

/// The poses of a campaign, numbered in the order in which it comes to know them, and what is measured in
/// place of those that fail.
class SessionPlan {
 public:
  /// @param run, devices  outlive it
  /// @param past  of a campaign that was interrupted, which has the same poses; null: it begins
  SessionPlan(CampaignRun& run, SessionDevices& devices, std::shared_ptr<const CampaignPast> past);

  /// Chooses poses and from then on knows ways and substitutes. The options' start, and what only
  /// their comparisons need, are set here.
  CampaignOutcome<void> choose(CalibratedCell cell, PlanOptions options,
                               Reflectors reflectors = Reflectors::First);
  const MeasurementPlan& chosen() const { return poses_->plan(); }

  /// Of a pose, or of what is measured like one.
  int next_number() { return next_number_++; }
  /// The next pose of the campaign.
  MeasuringTarget new_target(PointPurpose purpose, const JointVector& q,
                             Replacement replacement = Replacement::None);
  /// Keeps in the journal what is to be measured, as is done of each pose at the latest before the arm goes
  /// there.
  CampaignOutcome<void> keep(std::vector<MeasuringTarget> targets);
  /// What to measure in place of a pose that failed. Never more than were measured, so that a device that
  /// always fails does not make the campaign endless.
  CampaignOutcome<std::optional<MeasuringTarget>> substitute(MeasuringTarget failed);

 private:
  CampaignRun& run_;
  SessionDevices& devices_;
  std::shared_ptr<const CampaignPast> past_;
  std::shared_ptr<PoseSupply> poses_;
  std::set<int> in_journal_;  ///< numbers of poses
  int next_number_ = 1;       ///< of a pose
  int substitutes_ = 0;
};

}  // namespace truepose::daemon
