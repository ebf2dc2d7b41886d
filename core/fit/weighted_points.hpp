#pragma once

#include <optional>
#include <span>
#include <vector>

#include "core/data/measurement.hpp"
#include "core/fit/least_squares_problem.hpp"
#include "core/fit/robust_fit.hpp"

namespace truepose {

/// The points of an identification and how much each counts: whitened by its noise, weighed by the loss.
///
/// A point is trusted unless it is an outlier. One that the loss leaves in, for all that (Huber), may sway a
/// fit a little, but not choose what is fitted. Problems point into it: it must outlive them, and may be
/// moved but not copied.
class WeightedPoints {
 public:
  /// Every point of weight 1.
  WeightedPoints(std::vector<Measurement> points, const std::optional<MeasurementNoise>& noise);
  WeightedPoints(WeightedPoints&&) = default;
  WeightedPoints& operator=(WeightedPoints&&) = default;

  const std::vector<Measurement>& points() const { return points_; }
  const std::vector<Eigen::Matrix3d>& whitening() const { return whitening_; }  ///< empty = identity
  const std::vector<double>& turn_whitening() const { return turns_; }          ///< empty = no 6-D target
  const std::vector<double>& weights() const { return weights_; }
  double stated_sigma_mm() const { return stated_sigma_mm_; }  ///< of a whitened coordinate; 0 = unknown

  const std::vector<bool>& trusted() const { return trusted_; }
  std::vector<Measurement> trusted_points() const;

  /// Rows of the trusted points in a linear system: their coordinates, and the turns of their targets.
  int rows() const;
  /// The same without what the unknown mountings of 6-D targets take up.
  int equations() const;
  /// Length (mm) of a point's error once whitened.
  double whitened_length(std::size_t point, const Eigen::Vector3d& error_mm) const;

  /// The problem of fitting `free` under the present weights.
  LeastSquaresProblem problem(std::vector<int> free) const;
  /// Gives these points in a problem their present weights.
  void weigh(LeastSquaresProblem& problem) const;
  /// The whitening times the root of the weight, of each point; empty = identity.
  std::vector<Eigen::Matrix3d> weighted_whitening() const;
  /// The same of the trusted points.
  std::vector<Eigen::Matrix3d> trusted_whitening() const;
  /// Weights of the turns of 6-D targets, that of their point included; empty = none has one.
  std::vector<double> weighted_turns() const;
  std::vector<double> trusted_turns() const;

  /// Reweights every point by its distance from `cell`, unless all weights would stay as they are.
  /// @param sigma_mm  of one coordinate of a good point's whitened residual
  /// @return whether a weight changed
  bool weigh(const CalibratedCell& cell, Loss loss, double sigma_mm);

  double sigma_mm() const { return sigma_mm_; }  ///< by which the points were weighed last

 private:
  std::vector<Measurement> points_;
  std::vector<Eigen::Matrix3d> whitening_;
  std::vector<double> turns_;  ///< mm per rad of each point's orientation; empty = none has one
  double stated_sigma_mm_ = 0;
  std::vector<double> weights_;
  std::vector<bool> trusted_;
  double sigma_mm_ = 1;
};

}  // namespace truepose
