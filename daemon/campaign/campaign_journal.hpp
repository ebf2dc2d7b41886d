#pragma once

#include <boost/asio/awaitable.hpp>
#include <memory>
#include <optional>

#include "daemon/campaign/campaign_result.hpp"

namespace truepose::daemon {

/// Keeps one campaign. What returned without an error is on the disk. It stamps times and knows the
/// campaign's id.
class CampaignJournal {
 public:
  virtual ~CampaignJournal() = default;
  /// Called once, when the devices are known (or could not be reached: then their names are empty).
  virtual boost::asio::awaitable<StoreResult<void>> begin(Identities identities) = 0;
  virtual boost::asio::awaitable<StoreResult<void>> add_point(StoredPoint point) = 0;
  virtual boost::asio::awaitable<StoreResult<void>> add_skipped(SkippedPose skipped) = 0;
  /// @param result  of a campaign that is done; null otherwise
  virtual boost::asio::awaitable<StoreResult<void>> end(std::shared_ptr<const CampaignResult> result,
                                                        std::optional<CampaignError> error) = 0;
};

}  // namespace truepose::daemon
