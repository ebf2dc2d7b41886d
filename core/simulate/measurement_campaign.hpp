#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <vector>

#include "core/arm/robot_model.hpp"
#include "core/data/measurement.hpp"
#include "core/math/random.hpp"
#include "core/simulate/true_arm.hpp"

namespace truepose {

/// Standard deviation per axis of a tracker of 10 um, and of an arm of RP = 0.060 mm (ISO 9283: the mean
/// distance and three of its standard deviations are 3.6161 per axis).
inline constexpr double kTrackerNoise_mm = 0.010;
inline constexpr double kRepeatability_mm = 0.060 / 3.6161;

/// Readings that went wrong: a reflector knocked, a beam reflected twice.
struct GrossErrors {
  double fraction = 0;  ///< of the poses to identify, rounded to whole poses
  double min_mm = 5;    ///< length, uniform between these, in a random direction
  double max_mm = 50;
};

struct CampaignOptions {
  double tracker_noise_mm = kTrackerNoise_mm;
  GrossErrors gross;
  bool record_directions = true;  ///< into Measurement::direction
  /// Standard deviation of the turn about each axis that a 6-D target shows; 0: a reflector, which shows
  /// none.
  double turn_noise_rad = 0;
  std::uint64_t seed = 0;  ///< of every random number of the campaign, the arm's included
};

/// What a simulated campaign measured, and the truth that a real one never knows, point by point.
struct SimulatedCampaign {
  MeasurementData data;
  std::vector<Eigen::Vector3d> p_true_mm;   ///< where the arm stands on average: p_WS without any noise
  std::vector<Eigen::Vector3d> p_stood_mm;  ///< where it stood, its repeatability included
  std::vector<bool> gross;                  ///< whether the reading is an outlier
};

/// Drives the arm through the poses, in the given order, and measures its one reflector ("1") at each: first
/// the poses to identify, then those to validate. Two runs with the same arguments are the same.
SimulatedCampaign measure_campaign(const TrueArmSetup& arm, std::span<const JointVector> identify,
                                   std::span<const JointVector> validate, const CampaignOptions& options);

/// Poses uniform in the joint limits, with the flange above the floor on which the base stands.
std::vector<JointVector> random_poses(const RobotModel& robot, int count, Random& random);

}  // namespace truepose
