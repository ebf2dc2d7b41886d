#include "core/quality/iso9283.hpp"

#include <algorithm>

#include "core/math/rigid_fit.hpp"

namespace truepose {
namespace {

std::vector<TestPose> poses_of(const TestPoint& point, const std::string& direction,
                               const std::string& series) {
  std::vector<TestPose> poses;
  for (const AttainedPose& attained : point.attained) {
    if (attained.direction == direction && attained.series == series) poses.push_back(attained.pose);
  }
  return poses;
}

/// The different values of a member, in the order of first appearance.
template <typename Items, typename Member>
std::vector<std::string> different(const Items& items, Member member) {
  std::vector<std::string> values;
  for (const auto& item : items) {
    if (std::ranges::find(values, item.*member) == values.end()) values.push_back(item.*member);
  }
  return values;
}

std::string described(const TestPoint& point, const CycleSet& set) {
  return point.name + (set.direction.empty() ? "" : ", direction " + set.direction) +
         (set.series.empty() ? "" : ", series " + set.series);
}

std::expected<std::vector<CycleSet>, std::string> cycle_sets(std::span<const TestPoint> points) {
  std::vector<CycleSet> sets;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const TestPoint& point = points[i];
    for (const std::string& series : different(point.attained, &AttainedPose::series)) {
      for (const std::string& direction : different(point.attained, &AttainedPose::direction)) {
        const std::vector<TestPose> poses = poses_of(point, direction, series);
        if (poses.empty()) continue;
        CycleSet set{.point = i,
                     .direction = direction,
                     .series = series,
                     .cycles = static_cast<int>(poses.size()),
                     .mean = mean_pose(poses)};
        const auto repeatability = pose_repeatability(poses);
        if (!repeatability) return std::unexpected(described(point, set) + ": " + repeatability.error());
        set.characteristics = {pose_accuracy(point.commanded, poses), *repeatability};
        sets.push_back(std::move(set));
      }
    }
  }
  return sets;
}

/// The sets of one point that share a member's value.
std::vector<CycleSet> sets_of(std::span<const CycleSet> sets, std::size_t point,
                              std::string CycleSet::*member, const std::string& value) {
  std::vector<CycleSet> chosen;
  std::ranges::copy_if(sets, std::back_inserter(chosen),
                       [&](const CycleSet& set) { return set.point == point && set.*member == value; });
  return chosen;
}

void add_variations(Iso9283Result& result, std::size_t point) {
  for (const std::string& series : different(result.sets, &CycleSet::series)) {
    std::vector<CycleSet> sets = sets_of(result.sets, point, &CycleSet::series, series);
    // The cycles from pose to pose say nothing of directions.
    std::erase_if(sets, [](const CycleSet& set) { return set.direction.empty(); });
    if (sets.size() < 2) continue;
    std::vector<TestPose> means;
    for (const CycleSet& set : sets) means.push_back(set.mean);
    result.variations.push_back(
        {point, series, different(sets, &CycleSet::direction), accuracy_variation(means)});
  }
}

void add_drifts(Iso9283Result& result, std::size_t point) {
  for (const std::string& direction : different(result.sets, &CycleSet::direction)) {
    const std::vector<CycleSet> sets = sets_of(result.sets, point, &CycleSet::direction, direction);
    if (sets.size() < 2) continue;
    std::vector<SeriesCharacteristics> series;
    for (const CycleSet& set : sets) series.push_back(set.characteristics);
    result.drifts.push_back({point, direction, different(sets, &CycleSet::series), pose_drift(series)});
  }
}

}  // namespace

std::expected<Iso9283Result, std::string> evaluate_iso9283(std::span<const TestPoint> points) {
  auto sets = cycle_sets(points);
  if (!sets) return std::unexpected(sets.error());
  Iso9283Result result{.sets = *std::move(sets)};
  for (std::size_t point = 0; point < points.size(); ++point) {
    add_variations(result, point);
    add_drifts(result, point);
  }
  result.fewest_cycles = std::ranges::min_element(result.sets, {}, &CycleSet::cycles)->cycles;
  return result;
}

std::expected<Eigen::Isometry3d, std::string> fitted_frame(std::span<const TestPoint> points) {
  std::vector<Eigen::Vector3d> attained, commanded;
  for (const TestPoint& point : points) {
    std::vector<TestPose> poses;
    for (const AttainedPose& pose : point.attained) poses.push_back({.p_mm = pose.pose.p_mm});
    attained.push_back(mean_pose(poses).p_mm);
    commanded.push_back(point.commanded.p_mm);
  }
  return rigid_fit(attained, commanded);
}

std::vector<TestPoint> in_base(std::vector<TestPoint> points, const Eigen::Isometry3d& X_BM) {
  for (TestPoint& point : points) {
    for (AttainedPose& attained : point.attained) {
      attained.pose.p_mm = X_BM * attained.pose.p_mm;
      if (attained.pose.R) attained.pose.R = X_BM.linear() * *attained.pose.R;
    }
  }
  return points;
}

}  // namespace truepose
