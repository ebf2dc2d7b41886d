#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cstddef>
#include <span>
#include <vector>

namespace truepose {

/// The upper median; 0 of nothing.
inline double median(std::vector<double> values) {
  if (values.empty()) return 0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::ranges::nth_element(values, middle);
  return *middle;
}

/// Mean length over the root mean square length of a vector of three normal coordinates.
inline constexpr double kMeanOverRms = 0.9213177319235613;

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

/// By how many of its standard errors the mean of paired values falls from `before` to `after`. Where all
/// fall by the same it has none: infinity, and 0 where nothing falls.
///
/// @param before, after  as many, at least two
double standard_errors_gained(std::span<const double> before, std::span<const double> after);

/// Probability that a gamma variable of this shape and unit scale exceeds x: 1 where x <= 0. Exact to about
/// 1e-13 of itself.
///
/// @param shape  above 0
/// Source: Abramowitz, Stegun, Handbook of Mathematical Functions (1964), 6.5.29 (series) and 6.5.31
/// (continued fraction, by Lentz' recurrence).
double gamma_tail(double x, double shape);

/// Probability that a chi-square variable of so many degrees of freedom exceeds x.
inline double chi_square_tail(double x, int degrees) { return gamma_tail(x / 2, degrees / 2.0); }

}  // namespace truepose
