#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string_view>
#include <vector>

#include "core/data/calibrated_cell.hpp"
#include "core/simulate/true_arm.hpp"
#include "tools/experiment/experiment.hpp"

namespace truepose {

/// Joints at which the cell predicts its first reflector at a point, by the smallest joint change.
///
/// @param p_WS_mm  target of the reflector
/// @param q_seed   near it
/// @return nothing where the arm cannot reach it
std::optional<JointVector> joints_for_reflector(const CalibratedCell& cell, const Eigen::Vector3d& p_WS_mm,
                                                const JointVector& q_seed,
                                                const ApproachDirections& directions);

struct TrackerReadings {
  double noise_mm = 0;  ///< standard deviation of a coordinate
  int rounds = 6;
};

/// Tracker in the loop (TrackerLoop) at one target, without a tolerance.
///
/// @param arm   stands at `q` (its joints) for the target
/// @return where the arm truly stands at the end, its repeatability included
Eigen::Vector3d approach_with_tracker(TrueArm& arm, const CalibratedCell& cell,
                                      const Eigen::Vector3d& p_WS_mm, const JointVector& q,
                                      const TrackerReadings& readings, Random& random);

/// One random set-up of the paper's simulated arm: where it stands, how it is measured, and what is known of
/// it beforehand.
struct Trial {
  CalibratedCell truth;
  CalibratedCell guess;  ///< nominal arm, base and reflector off by ExperimentOptions::guess
  std::vector<JointVector> identify, validate;
  std::uint64_t noise_seed = 0;
};

/// The base anywhere from 3 to 6 m from the tracker, turned about all axes, the reflector 100 to 250 mm off
/// axis 6. Trial `index` of a seed is always the same.
Trial draw_trial(const RobotModel& nominal, const ExperimentOptions& options, int index);

/// The trial's arm, with or without further errors of its joints.
TrueArmSetup true_arm(const Trial& trial, const ExperimentOptions& options);

/// Readings of the trial's poses.
SimulatedCampaign measure_trial(const Trial& trial, const ExperimentOptions& options, TrialData data);

/// Calls run(0) .. run(count - 1) on as many threads as it is lent, and shows how far it is.
void run_trials(int count, const ExperimentHooks& hooks, std::string_view doing,
                const std::function<void(int)>& run);

/// Standard deviation of one coordinate of a reading, mm.
double reading_sigma_mm(const ExperimentOptions& options);

}  // namespace truepose
