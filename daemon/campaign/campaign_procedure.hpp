#pragma once

#include "daemon/campaign/campaign_result.hpp"

namespace truepose::daemon {

/// What one kind of campaign does with a session once the devices are connected. Made before that, when it
/// says how many poses there will be.
class CampaignProcedure {
 public:
  virtual ~CampaignProcedure() = default;
  virtual CampaignOutcome<void> run() = 0;
};

}  // namespace truepose::daemon
