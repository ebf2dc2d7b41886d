#include "core/quality/model_noise.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/calibrate/outlier_rejection.hpp"
#include "core/change/drift_causes.hpp"

namespace truepose {
namespace {

MeasurementNoise scaled(const MeasurementNoise& noise, double factor) {
  return {.tracker = {.range_mm = factor * noise.tracker.range_mm,
                      .range_mm_per_m = factor * noise.tracker.range_mm_per_m,
                      .transverse_mm = factor * noise.tracker.transverse_mm,
                      .transverse_mm_per_m = factor * noise.tracker.transverse_mm_per_m},
          .repeatability_mm = factor * noise.repeatability_mm};
}

/// Of points that each state their own: a later one is taken as all these.
MeasurementNoise root_mean_square(std::span<const Measurement> points) {
  double variance = 0;
  for (const Measurement& point : points) variance += *point.sigma_mm * *point.sigma_mm;
  return {.repeatability_mm = std::sqrt(variance / static_cast<double>(points.size()))};
}

}  // namespace

MeasurementNoise noise_about_model(const Calibration& calibration, const MeasurementData& data,
                                   const std::optional<MeasurementNoise>& stated) {
  const std::vector<Measurement> points = points_of(without(calibration.rejected, data), PoseSet::Identify);
  const Whitening whitening = whitening_of(points, stated);
  if (whitening.W.empty()) return {.repeatability_mm = calibration.sigma0_mm};
  MeasurementNoise about =
      std::ranges::all_of(points, &std::optional<double>::has_value, &Measurement::sigma_mm)
          ? root_mean_square(points)
          : *stated;
  about = scaled(about, std::min(1.0, calibration.sigma0_mm / whitening.finest_mm));
  about.repeatability_mm =
      std::hypot(about.repeatability_mm, beyond_noise_mm(whitening, calibration.sigma0_mm));
  return about;
}

std::vector<double> validation_distances2(const Calibration& calibration, const MeasurementData& data,
                                          const MeasurementNoise& about) {
  const DriftReference reference{
      .cell = calibration.cell, .covariance = calibration.covariance, .noise = about};
  // Of data without any noise nothing can be whitened.
  const MeasurementData trusted = without(calibration.rejected, data);
  return point_distances2(reference, points_of(trusted, PoseSet::Validate)).value_or(std::vector<double>{});
}

MeasurementNoise noise_of_mean_error(double mean_mm) {
  // The length of three normal coordinates is sqrt(8 / pi) of their standard deviations on average.
  return {.repeatability_mm = mean_mm / std::sqrt(8 / std::numbers::pi)};
}

}  // namespace truepose
