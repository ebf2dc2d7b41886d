#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstddef>
#include <expected>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/change/change_hypothesis.hpp"
#include "core/data/measurement.hpp"

namespace truepose {

/// Fixed reflectors (nests) as the tracker saw them at one time, or as the mean of several times. mm, tracker
/// frame.
struct NestReading {
  Eigen::Vector3d p_mm{0, 0, 0};
  int readings = 0;  ///< of which it is the mean; 0: it was not seen
};
using NestReadings = std::vector<NestReading>;  ///< nest by nest, each time in the same order

/// By what a tracker, or what it stands on, has moved between two times: shift of X at the centre, turn of X.
struct TrackerMotion : ChangeFound {
  /// Brings a point that is seen now to where it would have been seen then.
  Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
  Eigen::Vector3d centre_mm{0, 0, 0};                                            ///< of the nests
  Eigen::Matrix<double, 6, 6> covariance = Eigen::Matrix<double, 6, 6>::Zero();  ///< of shift and turn
  double probability = 1;       ///< that a tracker that stands still shows as much
  double fit = 1;               ///< that nests that stand still leave as much of a rigid motion
  std::vector<double> left_mm;  ///< by each nest: what the motion does not explain; 0 where it was not seen

  TrackerMotion() { moved = sigma = Eigen::VectorXd::Zero(6); }
  Eigen::Vector3d shift_mm() const { return moved.head<3>(); }
  Eigen::Vector3d turn_rad() const { return moved.tail<3>(); }
};

/// @param noise  of one reading; of places that an arm comes back to, with its repeatability
/// Errors: fewer than three nests were seen both times, or those on one line.
std::expected<TrackerMotion, std::string> tracker_motion(const NestReadings& then, const NestReadings& now,
                                                         const MeasurementNoise& noise);

/// A time in which the tracker stood still, as far as its nests tell.
struct TrackerStand {
  std::size_t first = 0, last = 0;  ///< checks, from 0
  NestReadings nests;               ///< the means of its checks
  TrackerMotion since_start;        ///< from the first stand
};

/// What the nests' checks of one campaign tell, in the order of measuring.
struct StandHistory {
  std::vector<TrackerStand> stands;  ///< one: it never moved
  std::vector<std::string> doubts;   ///< checks that say nothing, nests that moved by themselves; in words

  bool moved() const { return stands.size() > 1; }
  /// What brings a point to where the first stand would have seen it, measured the share `t` (0 to 1) of the
  /// way from one check to the next. Between two stands it moves evenly.
  Eigen::Isometry3d to_start(std::size_t check, double t) const;
  /// Whether it moved at some moment between this check and the next, where nothing shows when; rather than
  /// little by little, as it does where it moved before and after as well.
  bool stepped_after(std::size_t check) const;
};

/// A check belongs to the stand of those before it, unless a tracker that stands still would show as much at
/// one of all checks less often than kSignificance.
StandHistory stand_history(std::span<const NestReadings> checks, const TrackerNoiseModel& noise);

/// "the tracker moved by 0.052 mm (sigma 0.008) and 4 urad (sigma 2) between the nests' measurements 2 and
/// 3".
std::vector<std::string> described_moves(const StandHistory& history);

}  // namespace truepose
