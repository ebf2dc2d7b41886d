#include "core/change/reference_pose.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/change/drift_causes.hpp"
#include "core/formatted.hpp"
#include "core/math/dense_algebra.hpp"
#include "core/math/f_distribution.hpp"

namespace truepose {
namespace {

/// A single reading of the reference, as against the mean of those before and after, is a step where it
/// leaves so little of their squares.
constexpr double kStepLeaves = 0.25;

Eigen::Vector3d mean_of(std::span<const Eigen::Vector3d> readings_mm) {
  Eigen::Vector3d sum_mm(0, 0, 0);
  for (const Eigen::Vector3d& reading : readings_mm) sum_mm += reading;
  return sum_mm / static_cast<double>(readings_mm.size());
}

double sum_of_squares(std::span<const Eigen::Vector3d> readings_mm) {
  const Eigen::Vector3d mean_mm = mean_of(readings_mm);
  double sum = 0;
  for (const Eigen::Vector3d& reading : readings_mm) sum += (reading - mean_mm).squaredNorm();
  return sum;
}

double farthest_apart_mm(std::span<const Eigen::Vector3d> readings_mm) {
  double farthest_mm = 0;
  for (const Eigen::Vector3d& a : readings_mm)
    for (const Eigen::Vector3d& b : readings_mm) farthest_mm = std::max(farthest_mm, (a - b).norm());
  return farthest_mm;
}

/// How far apart those before a moment and those after it are, on average, at the moment where that is most:
/// one that moved before its last reading moved as far as before another.
double farthest_step_mm(std::span<const Eigen::Vector3d> readings_mm) {
  double farthest_mm = 0;
  for (std::size_t k = 1; k < readings_mm.size(); ++k) {
    const double step_mm = (mean_of(readings_mm.subspan(k)) - mean_of(readings_mm.first(k))).norm();
    farthest_mm = std::max(farthest_mm, step_mm);
  }
  return farthest_mm;
}

/// "it moved between its measurements 2 and 3", where it stood still before and after.
std::string moment_of(std::span<const Eigen::Vector3d> readings_mm) {
  const double all = sum_of_squares(readings_mm);
  for (std::size_t k = 1; k < readings_mm.size(); ++k) {
    const double apart = sum_of_squares(readings_mm.first(k)) + sum_of_squares(readings_mm.subspan(k));
    if (readings_mm.size() > 2 && apart < kStepLeaves * all)
      return " (something moved between its measurements " + std::to_string(k) + " and " +
             std::to_string(k + 1) + ")";
  }
  return {};
}

/// Part of the chance that the scatter takes: a step, by far the most usual, takes the rest.
constexpr double kOfScatter = 0.1;

/// A step before reading k, of noise that is known as well as by so many residuals.
ChangeEvidence step_before(std::span<const Eigen::Vector3d> whitened, std::size_t k, double degrees) {
  const auto n = static_cast<double>(whitened.size()), before = static_cast<double>(k);
  const double weight = before * (n - before) / n;
  const Eigen::Vector3d step = mean_of(whitened.subspan(k)) - mean_of(whitened.first(k));
  return {weight * Eigen::Matrix3d::Identity(), weight * step, {degrees, weight * step.squaredNorm(), 3}};
}

}  // namespace

std::optional<ReferenceMotion> moved_reference(std::span<const Eigen::Vector3d> readings_mm,
                                               const KnownNoise& noise, double accuracy_mm) {
  if (readings_mm.size() < 2) return std::nullopt;
  const Eigen::Matrix3d W = inverse_cholesky(reading_covariance(readings_mm.front(), noise.noise));
  std::vector<Eigen::Vector3d> whitened;
  for (const Eigen::Vector3d& reading : readings_mm) whitened.push_back(W * (reading - readings_mm.front()));
  const double moments = static_cast<double>(readings_mm.size()) - 1, squares = sum_of_squares(whitened);
  const bool large = farthest_step_mm(readings_mm) > kLargeFactor * accuracy_mm ||
                     squares > kMostScatter * kMostScatter * 3 * moments;
  std::vector<ChangeEvidence> steps;
  for (std::size_t k = 1; k < whitened.size(); ++k) steps.push_back(step_before(whitened, k, noise.degrees));
  const ChangeEvidence& step = *std::ranges::max_element(steps, {}, &ChangeEvidence::gain);
  const double scatter = f_tail(squares / (3 * moments), 3 * moments, noise.degrees);
  const double chance =
      std::min(moments * step.chance(noise.degrees) / (1 - kOfScatter), scatter / kOfScatter);
  if (!large || chance >= kSignificance) return std::nullopt;
  const Eigen::Matrix3d L = W.inverse();
  ReferenceMotion found;
  static_cast<ChangeFound&>(found) = {{{ChangeKind::Pose}, TimeProfile::Step},
                                      step.best() - std::log(moments),
                                      L * step.step(),
                                      (L * step.sigma().asDiagonal()).rowwise().norm()};
  found.sentence = name_of(found, {}, {}) + formatted(": its %zu measurements are up to %.3f mm apart%s",
                                                      readings_mm.size(), farthest_apart_mm(readings_mm),
                                                      moment_of(readings_mm).c_str());
  return found;
}

}  // namespace truepose
