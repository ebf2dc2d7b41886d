#pragma once

#include <cstdint>
#include <expected>
#include <optional>
#include <string>
#include <vector>

#include "core/plan/test_cube_poses.hpp"
#include "daemon/campaign/campaign_procedure.hpp"
#include "daemon/campaign/measuring_session.hpp"

namespace truepose::daemon {

struct Iso9283Order {
  std::optional<CalibratedCell> cell;  ///< the active model, where there is one
  bool compensate = true;              ///< by the model, which must then be given
  int cycles = kIso9283Cycles;
  bool variation = false;  ///< come to P1, P2 and P4 along the three axes of the base too
};

/// Measures the cycles of an ISO 9283 test (P5 to P1, each from the one before, then P4, P2 and P1 along each
/// axis where that was ordered), and evaluates them. With a model, accuracy is that in the robot's base;
/// without, the frame is fitted to the five points.
///
/// The poses are numbered as they are measured, as many to a cycle as it has stops.
class Iso9283Campaign final : public CampaignProcedure {
 public:
  Iso9283Campaign(MeasuringSession& session, Iso9283Order order);
  CampaignOutcome<void> run() override;

 private:
  /// A stop and its joints.
  struct Stop : Iso9283Stop {
    JointVector q_target, q_commanded;
    JointVector q_from;                   ///< empty: the stop before
    std::vector<std::int8_t> directions;  ///< of the joints there, see DeviationBasis::Approach
  };

  CampaignOutcome<void> plan();
  std::vector<Stop> stops() const;
  void foresee_directions();
  std::expected<void, std::string> compensate();
  MeasuringTarget target_of(const Stop& stop);
  CampaignOutcome<void> measure_cycles();
  std::vector<TestPoint> measured_points();
  CampaignOutcome<void> evaluate();

  MeasuringSession& session_;
  Iso9283Order order_;
  TestCubePoses poses_;
  std::vector<Stop> stops_;
};

}  // namespace truepose::daemon
