#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

namespace truepose {

/// Statistics of one coordinate of a position error, mm.
struct AxisStatistics {
  double mean_abs = 0;
  double rms = 0;
  double max_abs = 0;
};

/// Statistics of the length of a position error and of its coordinates, mm.
struct ErrorStatistics {
  int count = 0;
  double mean = 0;
  double rms = 0;
  double max = 0;
  double min = 0;
  double std = 0;  ///< sample standard deviation (n - 1); 0 for a single error
  AxisStatistics x, y, z;
};

/// @param errors  at least one error vector, mm
ErrorStatistics error_statistics(std::span<const Eigen::Vector3d> errors);

/// Whether a model is better than another by what both leave of the same points: by the mean error. The one
/// answer to it, in campaigns, on the command line and in reports.
inline bool improves(double before_mean_mm, double after_mean_mm) { return after_mean_mm < before_mean_mm; }
inline bool improves(const ErrorStatistics& before, const ErrorStatistics& after) {
  return improves(before.mean, after.mean);
}

}  // namespace truepose
