#pragma once

#include <vector>

#include "daemon/campaign/campaign_procedure.hpp"
#include "daemon/campaign/measuring_session.hpp"

namespace truepose::daemon {

/// Measures a few poses and judges whether the active model is still right.
class DriftCampaign final : public CampaignProcedure {
 public:
  DriftCampaign(MeasuringSession& session, DriftReference reference);
  CampaignOutcome<void> run() override;

 private:
  CampaignOutcome<void> plan();
  CampaignOutcome<void> judge();

  MeasuringSession& session_;
  std::vector<MeasuringTarget> targets_;
};

}  // namespace truepose::daemon
