#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <optional>
#include <span>

#include "core/change/change_evidence.hpp"
#include "core/data/calibrated_cell.hpp"
#include "core/data/measurement.hpp"

namespace truepose {

/// Residuals that a stated noise counts as: it is known to a quarter.
inline constexpr double kStatedCounts = 10;

/// Residuals of the points with the identified parameters, and their derivatives; in standard deviations
/// where the noise is known. Of a stop that several reflectors show the rows are their mean and their
/// differences, in place of the points.
struct TimeEvidence {
  Eigen::MatrixXd moves;  ///< derivatives to all parameters, mm at each point
  Eigen::MatrixXd J;      ///< the same, whitened
  Eigen::MatrixXd U;      ///< what they span
  Eigen::VectorXd r;      ///< residuals
  Eigen::VectorXd beams;  ///< of each point, whitened, unit length
  int degrees = 0;        ///< of freedom
  bool noise_known = false;

  /// Of the residuals: a stated noise is known to a quarter.
  NoiseScale noise() const {
    return {noise_known ? kStatedCounts : 0, r.squaredNorm(), static_cast<double>(degrees)};
  }
};

/// Where the three rows of a point begin.
inline Eigen::Index row_of(std::size_t point) { return 3 * static_cast<Eigen::Index>(point); }

TimeEvidence time_evidence(const CalibratedCell& cell, std::span<const Measurement> points,
                           const std::optional<MeasurementNoise>& stated);

}  // namespace truepose
