#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "core/planning/test_cube_poses.hpp"
#include "daemon/campaign/campaign_procedure.hpp"
#include "daemon/campaign/measuring_session.hpp"

namespace truepose::daemon {

struct Iso9283Order {
  std::optional<CalibratedCell> cell;  ///< the active model, where there is one
  bool compensate = true;              ///< by the model, which must then be given
  int cycles = kIso9283Cycles;
};

/// Measures the cycles of an ISO 9283 test (P5 to P1, each from the one before), and evaluates them. With a
/// model, accuracy is that in the robot's base; without, the frame is fitted to the five points.
///
/// The poses are numbered as they are measured, five to a cycle: the first of each is P5.
class Iso9283Campaign final : public CampaignProcedure {
 public:
  Iso9283Campaign(MeasuringSession& session, Iso9283Order order);
  CampaignOutcome<void> run() override;

 private:
  CampaignOutcome<void> plan();
  CampaignOutcome<void> measure_cycles();
  CampaignOutcome<void> evaluate();

  MeasuringSession& session_;
  Iso9283Order order_;
  TestCubePoses poses_;
  std::array<JointVector, 5> q_commanded_;
};

}  // namespace truepose::daemon
