#pragma once

#include <vector>

#include "daemon/campaign/campaign_procedure.hpp"
#include "daemon/campaign/measuring_session.hpp"

namespace truepose::daemon {

/// Identifies the arm from planned poses, validates on others, and proves by measuring again that
/// compensation works.
///
/// The poses are numbered: those planned to identify, those planned to validate, then what comes up on the
/// way (measurements of the reference pose, substitutes of poses that failed), then the validation poses
/// again with compensated joints.
class CalibrationCampaign final : public CampaignProcedure {
 public:
  explicit CalibrationCampaign(MeasuringSession& session);
  CampaignOutcome<void> run() override;

 private:
  using Targets = std::vector<MeasuringTarget>;

  CampaignOutcome<void> plan();
  void add_reference(const JointVector& q);
  MeasuringTarget reference(const JointVector& q);
  CampaignOutcome<void> warm_up();
  CampaignOutcome<void> measure_to_identify();
  CampaignOutcome<void> measure_to_validate();
  CampaignOutcome<void> fit_placement();
  CampaignOutcome<void> identify();
  boost::asio::awaitable<void> doubt();
  CampaignOutcome<void> remeasure();
  CampaignOutcome<Targets> compensate();
  void judge_remeasured();

  MeasuringSession& session_;
  Targets identify_, validate_;
};

}  // namespace truepose::daemon
