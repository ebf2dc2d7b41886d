#pragma once

#include <memory>
#include <vector>

#include "core/compensate/tracker_loop.hpp"
#include "daemon/campaign/campaign_procedure.hpp"
#include "daemon/campaign/measuring_session.hpp"

namespace truepose::daemon {

struct TargetsOrder {
  CalibratedCell cell;  ///< the active model
  /// Joints at which the nominal arm would be at each target; none: validation poses of a plan, as many as
  /// configured.
  std::vector<JointVector> targets;
  TrackerLoopOptions loop;
  int readings = 3;  ///< of the tracker in each round
};

/// Finds for each target the joints at which the real arm stands there: starts from those of the active
/// model, and corrects them by the tracker in the loop. A target is where the nominal arm would hold the
/// reflector, seen from the model's base.
class TargetsCampaign final : public CampaignProcedure {
 public:
  TargetsCampaign(MeasuringSession& session, TargetsOrder order);
  CampaignOutcome<void> run() override;

 private:
  /// Where the loop begins at one target, or why it does not.
  struct Start {
    JointVector q;
    std::string refusal;
  };

  CampaignOutcome<void> plan();
  CampaignOutcome<void> prepare();
  CampaignOutcome<void> close_in(MeasuringTarget target, Start start);

  MeasuringSession& session_;
  TargetsOrder order_;
  std::vector<MeasuringTarget> targets_;
  std::vector<Start> starts_;
};

}  // namespace truepose::daemon
