#include "core/calibration/measurement_noise.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/kinematics/units.hpp"
#include "core/linear_algebra/decompositions.hpp"

namespace truepose {
namespace {

Whitening by_stated_sigma(std::span<const Measurement> points) {
  Whitening whitening;
  whitening.finest_mm =
      *std::ranges::min_element(points, {}, [](const Measurement& m) { return *m.sigma_mm; })->sigma_mm;
  for (const Measurement& point : points) {
    whitening.W.push_back(Eigen::Matrix3d::Identity() * (whitening.finest_mm / *point.sigma_mm));
  }
  return whitening;
}

Whitening by_model(std::span<const Measurement> points, const MeasurementNoise& noise) {
  Whitening whitening;
  double finest_variance = std::numeric_limits<double>::infinity();
  for (const Measurement& point : points) {
    const Eigen::Matrix3d covariance = reading_covariance(point.p_WS_mm, noise);
    whitening.W.push_back(inverse_cholesky(covariance));
    finest_variance = std::min(finest_variance, eigenvalues(covariance)[0]);
  }
  whitening.finest_mm = std::sqrt(finest_variance);
  for (Eigen::Matrix3d& W : whitening.W) W *= whitening.finest_mm;
  return whitening;
}

}  // namespace

Eigen::Matrix3d reading_covariance(const Eigen::Vector3d& p_WS_mm, const MeasurementNoise& noise) {
  const double distance_mm = p_WS_mm.norm();
  const TrackerNoiseModel& tracker = noise.tracker;
  const double along = tracker.range_mm + tracker.range_mm_per_m * kMetresPerMm * distance_mm;
  const double across = tracker.transverse_mm + tracker.transverse_mm_per_m * kMetresPerMm * distance_mm;
  Eigen::Matrix3d covariance =
      Eigen::Matrix3d::Identity() * (across * across + noise.repeatability_mm * noise.repeatability_mm);
  if (distance_mm > 0) {
    const Eigen::Vector3d beam = p_WS_mm / distance_mm;
    covariance += (along * along - across * across) * beam * beam.transpose();
  }
  return covariance;
}

Whitening whitening_of(std::span<const Measurement> points, const std::optional<MeasurementNoise>& noise) {
  const auto stated = [](const Measurement& m) { return m.sigma_mm.has_value(); };
  if (!points.empty() && std::ranges::all_of(points, stated)) return by_stated_sigma(points);
  if (noise) return by_model(points, *noise);
  return {};
}

}  // namespace truepose
