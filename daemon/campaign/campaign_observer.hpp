#pragma once

#include <array>
#include <boost/asio/awaitable.hpp>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "daemon/campaign/campaign_result.hpp"

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
  Frame,
  Finish
};

/// The name on the wire: "warming_up", "remeasuring", "correcting".
inline std::string_view phase_name(CampaignPhase phase) {
  constexpr std::array<std::string_view, 11> names{"connecting", "computing", "warming_up",  "identifying",
                                                   "validating", "computing", "remeasuring", "correcting",
                                                   "cycling",    "measuring", "activating"};
  return names[static_cast<std::size_t>(phase)];
}

struct CampaignProgress {
  CampaignPhase phase = CampaignPhase::Connect;
  int done = 0;   ///< poses measured
  int total = 0;  ///< poses planned, those to measure again with compensated joints and substitutes included
  int skipped = 0;
  int left() const { return total - done - skipped; }
  std::optional<double>
      error_mm;  ///< mean distance from the prediction in this phase, once there is a good one
  std::optional<double>
      time_left_s;  ///< from the time that the poses so far took; grows with one that takes longer
};

/// Who watches a campaign. Called on its strand; returns soon.
class CampaignObserver {
 public:
  virtual ~CampaignObserver() = default;
  virtual void on_progress(const CampaignProgress& progress) = 0;
  /// @param deviation_mm  measured minus predicted, its length; 0 of a point that was touched
  virtual void on_point(const StoredPoint& point, double deviation_mm, const CampaignProgress& progress) = 0;
  /// @param wanted  the point that was not measured; `smr` are all reflectors that were looked for: "1, 2"
  virtual void on_skipped(const StoredPoint& wanted, const std::string& reason,
                          const CampaignProgress& progress) = 0;
  /// A failed attempt, a lost device, a robot that is not ready: what happened and what is done about it.
  virtual void on_trouble(const std::string& sentence) = 0;
  /// @param reason  why the campaign waits for the device; empty: it answers again
  virtual void on_waiting(CellDevice /*device*/, const std::string& /*reason*/) {}
  /// The store could not keep something. The campaign pauses where that may pass, and ends otherwise.
  virtual void on_store_failed(const StoreError& /*error*/) {}
  /// The campaign has paused itself, and moves nothing before it is resumed.
  virtual void on_paused(const std::string& sentence) = 0;
};

/// Keeps one campaign. What returned without an error is on the disk. It stamps times and knows the
/// campaign's id.
class CampaignJournal {
 public:
  virtual ~CampaignJournal() = default;
  /// Called once, before anything else.
  /// @param total  poses over all phases as they are known then
  /// @return when it began, or continues: RFC 3339
  virtual boost::asio::awaitable<StoreResult<std::string>> begin(int total) = 0;
  /// Once the devices are known.
  virtual boost::asio::awaitable<StoreResult<void>> know(Identities identities) = 0;
  /// Before the arm goes to any of them.
  /// @param total  poses over all phases as they are known now
  virtual boost::asio::awaitable<StoreResult<void>> add_planned(std::vector<PlannedPose> poses,
                                                                int total) = 0;
  /// @return the point as it was kept, with its time
  virtual boost::asio::awaitable<StoreResult<StoredPoint>> add_point(StoredPoint point) = 0;
  virtual boost::asio::awaitable<StoreResult<void>> add_skipped(SkippedPose skipped) = 0;
  /// @param sha256  by which it is known again
  virtual boost::asio::awaitable<StoreResult<void>> add_identified(std::string sha256) = 0;
  virtual boost::asio::awaitable<StoreResult<void>> add_resumption(Resumption resumption) = 0;
  /// @param result  of a campaign that is done; null otherwise
  virtual boost::asio::awaitable<StoreResult<void>> end(std::shared_ptr<const CampaignResult> result,
                                                        std::optional<CampaignError> error) = 0;
};

}  // namespace truepose::daemon
