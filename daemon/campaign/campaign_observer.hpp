#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "daemon/store/store.hpp"

namespace truepose::daemon {

enum class CampaignPhase {
  Connect,
  Plan,
  WarmUp,
  Identify,
  Validate,
  Compute,
  Remeasure,
  Targets,
  Cycles,
  Finish
};

/// The name on the wire: "warming_up", "remeasuring", "correcting".
std::string_view phase_name(CampaignPhase phase);

struct CampaignProgress {
  CampaignPhase phase = CampaignPhase::Connect;
  int done = 0;   ///< poses measured or skipped
  int total = 0;  ///< poses planned, those to measure again with compensated joints and substitutes included
  int skipped = 0;
  std::optional<double>
      error_mm;  ///< mean distance from the prediction in this phase, once there is a good one
  std::optional<double> time_left_s;  ///< from the time that the poses so far took
};

/// Who watches a campaign. Called on its strand; returns soon.
class CampaignObserver {
 public:
  virtual ~CampaignObserver() = default;
  virtual void on_progress(const CampaignProgress& progress) = 0;
  /// @param deviation_mm  measured minus predicted, its length
  virtual void on_point(const StoredPoint& point, double deviation_mm, const CampaignProgress& progress) = 0;
  virtual void on_skipped(const SkippedPose& skipped, const CampaignProgress& progress) = 0;
  /// A failed attempt, a lost device, a robot that is not ready: what happened and what is done about it.
  virtual void on_trouble(const std::string& sentence) = 0;
  /// The campaign has paused itself, and moves nothing before it is resumed.
  virtual void on_paused(const std::string& sentence) = 0;
};

}  // namespace truepose::daemon
