#include "core/change/two_face.hpp"

#include <algorithm>
#include <cmath>

#include "core/change/change_hypothesis.hpp"
#include "core/formatted.hpp"
#include "core/math/dense_algebra.hpp"
#include "core/math/statistics.hpp"

namespace truepose {
namespace {

constexpr std::size_t kFewestPairs = 3;
constexpr double kUsual_rad = 1e-4;  // of each constant, as trackers that were never compensated have

/// By how much each constant moves a point, mm.
Eigen::Matrix3d effects(const Eigen::Vector3d& p_mm) {
  const double distance_mm = p_mm.norm(), across_mm = std::hypot(p_mm.x(), p_mm.y());
  const Eigen::Vector3d sideways = Eigen::Vector3d(-p_mm.y(), p_mm.x(), 0) / across_mm;
  const Eigen::Vector3d downwards = sideways.cross(p_mm / distance_mm);
  Eigen::Matrix3d J;
  // An angle h about the vertical axis moves it by across h; 1 / sin and cot of the vertical angle follow.
  J << distance_mm * sideways, p_mm.z() * sideways, distance_mm * downwards;
  return J;
}

}  // namespace

bool AimingConstants::significant() const { return probability < kSignificance; }

Eigen::Vector3d AimingConstants::corrected(const Eigen::Vector3d& face1_mm) const {
  return face1_mm - effects(face1_mm) * value;
}

std::optional<AimingConstants> aiming_constants(std::span<const FacePair> pairs,
                                                const TrackerNoiseModel& noise) {
  if (pairs.size() < kFewestPairs) return std::nullopt;
  Eigen::Matrix3d N = Eigen::Matrix3d::Identity() / (kUsual_rad * kUsual_rad);
  Eigen::Vector3d b = Eigen::Vector3d::Zero();
  double without2 = 0;
  for (const FacePair& pair : pairs) {
    // Half the difference of two readings.
    const Eigen::Matrix3d W = inverse_cholesky(reading_covariance(pair.mean_mm, {.tracker = noise}) / 2);
    const Eigen::Matrix3d J = W * effects(pair.mean_mm);
    const Eigen::Vector3d half = W * (pair.face1_mm - pair.mean_mm);
    N += J.transpose() * J;
    b += J.transpose() * half;
    without2 += half.squaredNorm();
  }
  AimingConstants constants;
  constants.covariance = inverse(N);
  constants.value = constants.covariance * b;
  const double explained2 = b.dot(constants.value);
  constants.probability = chi_square_tail(explained2, 3);
  constants.fit = chi_square_tail(without2 - explained2, 3 * static_cast<int>(pairs.size()) - 3);
  for (const FacePair& pair : pairs)
    constants.largest_mm = std::max(constants.largest_mm, (effects(pair.mean_mm) * constants.value).norm());
  return constants;
}

std::string described(const AimingConstants& constants) {
  const Eigen::Vector3d urad = 1e6 * constants.value;
  const Eigen::Vector3d sigma = 1e6 * constants.covariance.diagonal().cwiseSqrt();
  return formatted(
      "in one face the tracker errs by up to %.3f mm (collimation %.1f, tilt %.1f, index %.1f urad; sigma %.1f, "
      "%.1f, %.1f)",
      constants.largest_mm, urad[0], urad[1], urad[2], sigma[0], sigma[1], sigma[2]);
}

}  // namespace truepose
