#pragma once

#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "daemon/campaign/campaign_observer.hpp"
#include "daemon/campaign/campaign_past.hpp"
#include "drivers/clock.hpp"

namespace truepose::daemon {

/// How far a campaign is, and how long it will take.
class ProgressCounter {
 public:
  /// @param clock, observer  outlive it
  /// @param past  of a campaign that was interrupted: it is as far as that from the start; null: it begins
  ProgressCounter(drivers::Clock& clock, CampaignObserver& observer, std::shared_ptr<const CampaignPast> past)
      : clock_{clock}, observer_{observer}, past_{std::move(past)} {}

  void enter(CampaignPhase phase);
  /// @param poses  fewer than none where some turn out not to be needed
  void add_to_total(int poses) { counted_.total += poses; }
  void count_done() { ++counted_.done; }
  void count_skipped() { ++counted_.skipped; }
  /// Of a point whose place was well predicted.
  void count_error(double deviation_mm);
  /// The first one begins here, each other one where the one before ends.
  void begin_pose();
  void end_pose();
  /// All of the past was counted.
  void end_past() { past_.reset(); }

  void report() const { observer_.on_progress(now()); }
  CampaignProgress now() const;
  /// Without what is still to come of the past.
  const CampaignProgress& counted() const { return counted_; }

 private:
  std::optional<double> time_left_s() const;

  drivers::Clock& clock_;
  CampaignObserver& observer_;
  std::shared_ptr<const CampaignPast> past_;
  CampaignProgress counted_;
  double error_sum_mm_ = 0;  ///< of this phase, since there is a good prediction
  int error_count_ = 0;
  std::optional<drivers::TimePoint> pose_begun_;  ///< when the pose under way was, or the last one ended
  std::vector<double> pose_times_s_;
};

}  // namespace truepose::daemon
