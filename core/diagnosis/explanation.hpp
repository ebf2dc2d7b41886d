#pragma once

#include <span>
#include <string>
#include <vector>

#include "core/data/calibrated_cell.hpp"
#include "core/diagnosis/mistakes.hpp"

namespace truepose {

/// How well a case explains its points, with base, reflectors and links fitted to them.
struct Explanation {
  CalibratedCell cell;
  double coarse_mm = 0;         ///< median miss of the points with the links as they are
  std::vector<double> miss_mm;  ///< of each point with the links fitted too
  double deviation = 0;         ///< squared deviations of the links, each over what arms are usually off by
  double largest_deviation = 0;

  double error_mm() const;  ///< median of miss_mm
  /// Squared misses in standard deviations of a coordinate, of an outlier no more than some.
  double misfit(double sigma_mm) const;
  double share_missed() const;  ///< part of the points that it misses many times as far as the middle one
};

/// Distances of the points from where the cell's arm puts them.
std::vector<double> misses(const CalibratedCell& cell, std::span<const Measurement> points);

/// Distances of the points from their middle: the median of each coordinate.
std::vector<double> distances_from_middle(std::span<const Measurement> points);

/// Base, reflectors and what is open fitted to the better part of the points, so that a few outliers do not
/// speak against the arm.
CalibratedCell placed(const ModelAndPoints& given, std::span<const std::string> smr_names);

/// What `placed` leaves in the middle, at a fraction of its cost.
double rough_error(const ModelAndPoints& given, std::span<const std::string> smr_names);

/// Fits the links too, each held to where it is by what arms are off by, from a start and from the points
/// that are trusted there.
Explanation explanation(const ModelAndPoints& given, const CalibratedCell& start);

/// Standard deviation (3 mm, 15 mrad) by which a parameter of a real arm's links is off.
double usual_deviation(int parameter);

inline constexpr double kDetectable_mm = 0.05;  ///< more than a tracker and bearings leave at random
inline constexpr double kMostSigmas = 3;        ///< a link off by more is no mere deviation
inline constexpr double kGrossErrors = 0.1;  ///< part of the points that may be wrong in files that are right

}  // namespace truepose
