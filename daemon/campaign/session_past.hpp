#pragma once

#include <expected>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "daemon/campaign/session_devices.hpp"

namespace truepose::daemon {

/// What a campaign that continues takes from its past: what was measured or skipped, step by step, so that
/// the same steps lead to where it was interrupted. One that begins has none, and takes nothing.
class SessionPast {
 public:
  /// @param run  outlives it
  SessionPast(CampaignRun& run, std::shared_ptr<const CampaignPast> past);

  /// Whether the campaign continues where it was interrupted.
  bool resumes() const { return past_ != nullptr; }
  /// Whether what was measured is taken for good: nothing speaks against resuming.
  bool has_resumed() const { return has_resumed_; }
  /// Whether the next step is in it.
  bool has_more() const { return left_ > 0; }

  /// Takes note of when the campaign continues, RFC 3339.
  void begin(const std::string& time);
  /// Error: the arm is another one.
  Done check_arm() const;
  /// Takes note in the journal of what was found to have moved, once.
  CampaignOutcome<void> note_resumption();

  using Points = std::vector<StoredPoint>;
  /// What a pose came to: its points, without those of face 1 alone; none of one that was skipped.
  /// @return nothing where it is still to be measured. Error: the past does not follow from the plan
  std::expected<std::optional<Points>, CampaignError> take(const MeasuringTarget& target);
  /// A pose of which not all reflectors had been stored is taken with those that were.
  Points take_points(int number, PointPurpose purpose, std::string_view smr = {});
  /// @return whether it was there. Error: what was touched is of another order
  std::expected<bool, CampaignError> take_touch(int number, const std::string& point);
  bool take_skipped(int pose);
  /// Compensated joints stay those of the model that was found first.
  JointVector commanded(const MeasuringTarget& target) const;
  /// Keeps the hash of what was identified, or compares it with that of before.
  CampaignOutcome<void> keep_identified(std::string sha256);

 private:
  std::optional<CampaignError> contradiction(const MeasuringTarget& target) const;

  CampaignRun& run_;
  std::shared_ptr<const CampaignPast> past_;
  std::size_t left_ = 0;  ///< outcomes that were not taken yet
  bool has_resumed_ = false;
};

}  // namespace truepose::daemon
