#pragma once

#include <cstdint>
#include <vector>

#include "core/calibration/calibrated_cell.hpp"
#include "core/experiment/experiment.hpp"

namespace truepose {

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

/// Standard deviation of one coordinate of a reading, mm.
double reading_sigma_mm(const ExperimentOptions& options);

}  // namespace truepose
