#include "core/calibrate/station_split.hpp"

#include <algorithm>
#include <set>
#include <utility>
#include <vector>

#include "core/calibrate/station_start.hpp"

namespace truepose {
namespace {

std::set<int> reflectors_seen_from(const MeasurementData& data, int station) {
  std::set<int> seen;
  for (const Measurement& point : data.points)
    if (point.station == station) seen.insert(point.smr);
  return seen;
}

/// Poses that tell where the tracker stood; none where there is no other place.
int poses_to_place(const MeasurementData& data, int station) {
  if (data.station_count() == 1) return 0;
  const std::set<int> seen = reflectors_seen_from(data, station);
  const bool shared = std::ranges::any_of(data.points, [&](const Measurement& point) {
    return point.station != station && seen.contains(point.smr);
  });
  return shared ? kPosesToPlaceByReflectors : kPosesToPlace;
}

int poses_of(const MeasurementData& data, int station, std::optional<PoseSet> set = {}) {
  std::vector<Measurement> points;
  std::ranges::copy_if(data.points, std::back_inserter(points), [&](const Measurement& point) {
    return point.station == station && (!set || point.set == *set);
  });
  return count_poses(points);
}

/// Indices of the points that are drawn with each station.
std::vector<std::vector<std::size_t>> drawn_with(const MeasurementData& data) {
  std::vector<int> size;
  for (int station = 0; station < data.station_count(); ++station) size.push_back(poses_of(data, station));
  std::vector<std::vector<std::size_t>> points(size.size());
  for (const std::vector<std::size_t>& pose : pose_groups(data.points)) {
    const auto station_of = [&](std::size_t i) { return static_cast<std::size_t>(data.points[i].station); };
    const std::size_t smallest = *std::ranges::min_element(
        pose, {}, [&](std::size_t i) { return std::pair(size[station_of(i)], station_of(i)); });
    auto& with = points[station_of(smallest)];
    with.insert(with.end(), pose.begin(), pose.end());
  }
  for (auto& with : points) std::ranges::sort(with);
  return points;
}

/// `draw` marks the points of each station by themselves.
///
/// @param draw  of the station, its points and how many poses those before have
template <typename Draw>
void draw_each(MeasurementData& data, Draw draw) {
  int before = 0;
  int station = 0;
  for (const std::vector<std::size_t>& points : drawn_with(data)) {
    MeasurementData part;
    for (const std::size_t i : points) part.points.push_back(data.points[i]);
    draw(station++, part, before);
    before += count_poses(part.points);
    for (std::size_t k = 0; k < points.size(); ++k) data.points[points[k]].set = part.points[k].set;
  }
}

/// Stations are drawn independently of each other.
std::uint64_t seed_of(int station, std::uint64_t seed) {
  return seed ^ (static_cast<std::uint64_t>(station) << 32U);
}

}  // namespace

void split_each_station(MeasurementData& data, double fraction, std::uint64_t seed) {
  draw_each(data, [&](int station, MeasurementData& part, int) {
    const double least =
        static_cast<double>(poses_to_place(data, station)) / std::max(1, count_poses(part.points));
    split_poses(part, std::clamp(least, fraction, 1.0), seed_of(station, seed));
  });
}

void hold_out_fold_of_each_station(MeasurementData& data, int folds, int fold, std::uint64_t seed) {
  draw_each(data, [&](int station, MeasurementData& part, int before) {
    // The first pose of a station continues where those before it ended, so that all folds are alike.
    const int of_part = (fold + folds - before % folds) % folds;
    hold_out_fold(part, folds, of_part, seed_of(station, seed));
  });
}

std::optional<std::string> unplaced_station(const MeasurementData& marked) {
  for (int station = 0; station < marked.station_count(); ++station) {
    const int left = poses_of(marked, station, PoseSet::Identify), least = poses_to_place(marked, station);
    if (left < least)
      return station_prefix(marked, station) + std::to_string(left) + " of its " +
             std::to_string(poses_of(marked, station)) + " poses are left to identify, and " +
             std::to_string(least) + " place it";
  }
  return std::nullopt;
}

}  // namespace truepose
