#pragma once

#include <span>
#include <vector>

#include "core/arm/robot_model.hpp"

namespace truepose {

/// The axes at one time of a program, in the robot file's order. rad.
struct AxisSample {
  double time_s = 0;
  JointVector set;         ///< programmed, without the correction
  JointVector correction;  ///< in effect at the controller
  JointVector actual;      ///< as the encoders read
};

/// Whether no time is missing from one sample to the next.
bool goes_on(double from_s, double to_s);

/// How one axis follows its set points: nothing for the dead time, then a first-order lag.
struct AxisLag {
  double dead_time_s = 0;
  double time_constant_s = 0;
  bool identified = false;  ///< false: the axis moved too little, and the mean of the other axes stands here

  /// By how much a steady motion comes later.
  double delay_s() const { return dead_time_s + time_constant_s; }
};

struct DriveLag {
  std::vector<AxisLag> axes;
  double residual_rad = 0;  ///< RMS of actual less lagged axis, of those that were identified

  /// Mean of the identified axes; 0 where there is none.
  double mean_delay_s() const;
};

/// Identifies the lag of each axis from what it was given (set + correction) and where it was: least squares
/// over dead time and time constant, both not negative, 0.5 s together at most.
///
/// @param samples  in the order of time, some hundredths of a second apart; where more than 0.2 s are missing
///   the axis is taken to start again from its actual position
/// No axis is identified that moves by less than 0.5 deg.
DriveLag identify_drive_lag(std::span<const AxisSample> samples);

/// Where the axes would be, had the drives followed the set points alone: the set points with the lag
/// applied, one for each sample. rad.
std::vector<JointVector> lagged_set_points(std::span<const AxisSample> samples, const DriveLag& lag);

}  // namespace truepose
