#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "config/cell_config.hpp"
#include "core/plan/measurement_plan.hpp"
#include "daemon/store/campaign_plan.hpp"
#include "daemon/store/store.hpp"

namespace truepose::daemon {

/// What an interrupted campaign had come to, as the store has it. It continues by taking the same steps once
/// more: what was measured or skipped is taken from here, until a step comes that was not taken yet.
struct CampaignPast {
  CampaignRecord record;
  CampaignPlan plan;
  std::vector<StoredPoint> points;  ///< in the order of measuring
  std::vector<SkippedPose> skipped;
  std::vector<Resumption> resumptions;  ///< of before
  int nests = 0;                        ///< that the cell had

  /// @param smr  the reflector's name; empty: any
  const StoredPoint* point(int pose, PointPurpose purpose, std::string_view smr = {}) const;
  /// Those of all reflectors there, in the order of measuring.
  std::vector<const StoredPoint*> points_of(int pose, PointPurpose purpose, std::string_view smr = {}) const;
  const SkippedPose* skipped_pose(int pose) const;
  const PlannedPose* planned(int pose) const;
  const PlannedPose* substitute_of(int pose) const;
  int poses_done() const;
  /// Points of poses and nests, and poses skipped.
  std::size_t outcomes() const;
  /// What was planned; nothing where it was interrupted before that.
  std::optional<EarlierPlan> earlier_plan() const;

  /// Why the campaign cannot continue in the cell as its file describes it now, one sentence that begins with
  /// what does not fit; nothing where it can.
  std::optional<std::string> misfit(const config::CellConfig& config) const;
};

/// Error also where there is no such campaign, or it has no plan.
StoreResult<CampaignPast> read_past(Store& store, const std::string& campaign_id);

/// "the campaign was interrupted (2026-01-31T12:00:00Z) and went on (2026-01-31T12:10:00Z): nothing moved".
std::string described(const Resumption& resumption);

/// The point as the tracker would have seen it when the campaign began.
StoredPoint in_first_frame(StoredPoint point, const std::vector<Resumption>& resumptions);

}  // namespace truepose::daemon
