#include "core/quality/pose_characteristics.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "core/math/angles.hpp"

namespace truepose {
namespace {

bool all_oriented(std::span<const TestPose> poses) {
  return std::ranges::all_of(poses, [](const TestPose& pose) { return pose.R.has_value(); });
}

/// The mean by Karcher's iteration; each step leaves about the cube of the spread.
Eigen::Matrix3d mean_orientation(std::span<const TestPose> poses) {
  constexpr int kMaxSteps = 50;
  constexpr double kDone_rad = 1e-14;
  Eigen::Matrix3d R = *poses.front().R;
  for (int step = 0; step < kMaxSteps; ++step) {
    Eigen::Vector3d mean = Eigen::Vector3d::Zero();
    for (const TestPose& pose : poses) mean += turn_between(R, *pose.R);
    mean /= static_cast<double>(poses.size());
    R = rotation_by(mean) * R;
    if (mean.norm() < kDone_rad) break;
  }
  return R;
}

/// The greater of what was found and of what is new, axis by axis; nothing where one is unknown.
void keep_greater(std::optional<Eigen::Vector3d>& found, const std::optional<Eigen::Vector3d>& a,
                  const std::optional<Eigen::Vector3d>& b) {
  found = found && a && b ? std::optional(found->cwiseMax((*a - *b).cwiseAbs()).eval()) : std::nullopt;
}

}  // namespace

TestPose mean_pose(std::span<const TestPose> attained) {
  assert(!attained.empty());
  TestPose mean;
  for (const TestPose& pose : attained) mean.p_mm += pose.p_mm;
  mean.p_mm /= static_cast<double>(attained.size());
  if (all_oriented(attained)) mean.R = mean_orientation(attained);
  return mean;
}

PoseAccuracy pose_accuracy(const TestPose& commanded, std::span<const TestPose> attained) {
  const TestPose mean = mean_pose(attained);
  PoseAccuracy accuracy;
  accuracy.xyz_mm = mean.p_mm - commanded.p_mm;
  accuracy.p_mm = accuracy.xyz_mm.norm();
  if (commanded.R && mean.R) accuracy.abc_rad = turn_between(*commanded.R, *mean.R);
  return accuracy;
}

std::expected<PoseRepeatability, std::string> pose_repeatability(std::span<const TestPose> attained) {
  if (attained.size() < 2) return std::unexpected("one cycle has no repeatability, at least 2 are needed");
  const auto n = static_cast<double>(attained.size());
  const TestPose mean = mean_pose(attained);
  PoseRepeatability repeatability;
  for (const TestPose& pose : attained) repeatability.mean_mm += (pose.p_mm - mean.p_mm).norm() / n;
  double squares = 0;
  Eigen::Array3d turn_squares = Eigen::Array3d::Zero();
  for (const TestPose& pose : attained) {
    squares += std::pow((pose.p_mm - mean.p_mm).norm() - repeatability.mean_mm, 2);
    if (mean.R) turn_squares += turn_between(*mean.R, *pose.R).array().square();
  }
  repeatability.std_mm = std::sqrt(squares / (n - 1));
  repeatability.l_mm = repeatability.mean_mm + 3 * repeatability.std_mm;
  if (mean.R) repeatability.abc_rad = 3 * (turn_squares / (n - 1)).sqrt().matrix();
  return repeatability;
}

AccuracyVariation accuracy_variation(std::span<const TestPose> means) {
  assert(means.size() >= 2);
  AccuracyVariation variation;
  if (all_oriented(means)) variation.abc_rad = Eigen::Vector3d::Zero();
  for (std::size_t h = 0; h < means.size(); ++h) {
    for (std::size_t k = h + 1; k < means.size(); ++k) {
      variation.p_mm = std::max(variation.p_mm, (means[h].p_mm - means[k].p_mm).norm());
      if (!variation.abc_rad) continue;
      const Eigen::Vector3d turn = turn_between(*means[h].R, *means[k].R);
      variation.abc_rad = variation.abc_rad->cwiseMax(turn.cwiseAbs());
    }
  }
  return variation;
}

PoseDrift pose_drift(std::span<const SeriesCharacteristics> series) {
  assert(series.size() >= 2);
  const auto& [accuracy, repeatability] = series.front();
  PoseDrift drift{.ap_abc_rad = Eigen::Vector3d::Zero(), .rp_abc_rad = Eigen::Vector3d::Zero()};
  for (const SeriesCharacteristics& later : series.subspan(1)) {
    drift.ap_p_mm = std::max(drift.ap_p_mm, std::abs(later.accuracy.p_mm - accuracy.p_mm));
    drift.rp_l_mm = std::max(drift.rp_l_mm, std::abs(later.repeatability.l_mm - repeatability.l_mm));
    drift.moved_mm = std::max(drift.moved_mm, (later.accuracy.xyz_mm - accuracy.xyz_mm).norm());
    keep_greater(drift.ap_abc_rad, later.accuracy.abc_rad, accuracy.abc_rad);
    keep_greater(drift.rp_abc_rad, later.repeatability.abc_rad, repeatability.abc_rad);
  }
  return drift;
}

}  // namespace truepose
