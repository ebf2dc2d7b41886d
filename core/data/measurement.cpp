#include "core/data/measurement.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <iterator>
#include <limits>
#include <numeric>
#include <utility>
#include <vector>

#include "core/math/dense_algebra.hpp"
#include "core/math/random.hpp"
#include "core/math/units.hpp"

namespace truepose {

std::vector<int> pose_numbers(std::span<const Measurement> points) {
  // Sorted, those of one pose stand side by side, the first of them in front.
  std::vector<std::size_t> sorted(points.size());
  std::iota(sorted.begin(), sorted.end(), std::size_t{0});
  std::ranges::stable_sort(sorted, std::ranges::lexicographical_compare,
                           [&](std::size_t i) -> const JointVector& { return points[i].q; });
  std::vector<std::size_t> first_of(points.size());
  for (std::size_t k = 0; k < sorted.size(); ++k) {
    const bool same = k > 0 && std::ranges::equal(points[sorted[k]].q, points[sorted[k - 1]].q);
    first_of[sorted[k]] = same ? first_of[sorted[k - 1]] : sorted[k];
  }
  std::vector<int> numbers(points.size());
  int poses = 0;
  for (std::size_t i = 0; i < points.size(); ++i)
    numbers[i] = first_of[i] == i ? poses++ : numbers[first_of[i]];
  return numbers;
}

std::vector<int> named_pose_numbers(std::span<const Measurement> points) {
  std::vector<int> numbers = pose_numbers(points);
  const bool own = std::ranges::all_of(points, [](const Measurement& point) { return point.pose > 0; });
  for (std::size_t i = 0; i < points.size(); ++i) numbers[i] = own ? points[i].pose : numbers[i] + 1;
  return numbers;
}

std::vector<std::vector<std::size_t>> pose_groups(std::span<const Measurement> points) {
  const std::vector<int> numbers = pose_numbers(points);
  std::vector<std::vector<std::size_t>> groups(static_cast<std::size_t>(count_poses(points)));
  for (std::size_t i = 0; i < points.size(); ++i) groups[static_cast<std::size_t>(numbers[i])].push_back(i);
  return groups;
}

int count_poses(std::span<const Measurement> points) {
  const std::vector<int> numbers = pose_numbers(points);
  return numbers.empty() ? 0 : *std::ranges::max_element(numbers) + 1;
}

std::vector<Measurement> points_of(const MeasurementData& data, PoseSet set) {
  std::vector<Measurement> points;
  std::ranges::copy_if(data.points, std::back_inserter(points),
                       [set](const Measurement& m) { return m.set == set; });
  return points;
}

namespace {

/// The index of a name, which is added where it is new.
int index_in(std::vector<std::string>& names, const std::string& name) {
  const auto found = std::ranges::find(names, name);
  const auto index = static_cast<int>(found - names.begin());
  if (found == names.end()) names.push_back(name);
  return index;
}

void add_point(MeasurementData& data, Measurement point, const std::vector<std::string>& smr_names,
               int station) {
  point.smr = index_in(data.smr_names, smr_names[static_cast<std::size_t>(point.smr)]);
  point.station = station;
  data.points.push_back(std::move(point));
}

}  // namespace

std::string station_prefix(const MeasurementData& data, int station) {
  if (data.station_count() == 1) return {};
  return "station '" + data.stations[static_cast<std::size_t>(station)] + "': ";
}

MeasurementData of_station(const MeasurementData& data, int station) {
  MeasurementData of;
  if (!data.stations.empty()) of.stations = {data.stations[static_cast<std::size_t>(station)]};
  for (const Measurement& point : data.points)
    if (point.station == station) add_point(of, point, data.smr_names, 0);
  return of;
}

void add_station(MeasurementData& data, MeasurementData station) {
  const int index = data.station_count();
  data.stations.insert(data.stations.end(), station.stations.begin(), station.stations.end());
  for (Measurement& point : station.points) add_point(data, std::move(point), station.smr_names, index);
}

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
    const Eigen::Matrix3d covariance = point_covariance(point, noise);
    whitening.W.push_back(inverse_cholesky(covariance));
    finest_variance = std::min(finest_variance, eigenvalues(covariance)[0]);
  }
  whitening.finest_mm = std::sqrt(finest_variance);
  for (Eigen::Matrix3d& W : whitening.W) W *= whitening.finest_mm;
  return whitening;
}

}  // namespace

double beyond_noise_mm(const Whitening& whitening, double sigma0_mm) {
  const double more = sigma0_mm * sigma0_mm - whitening.finest_mm * whitening.finest_mm;
  if (whitening.W.empty() || more <= 0) return 0;
  double squares = 0;
  for (const Eigen::Matrix3d& W : whitening.W) squares += W.squaredNorm();
  return std::sqrt(more * 3 * static_cast<double>(whitening.W.size()) / squares);
}

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

Eigen::Matrix3d point_covariance(const Measurement& point, const MeasurementNoise& noise) {
  return reading_covariance(point.p_WS_mm, noise) +
         point.excess_mm * point.excess_mm * Eigen::Matrix3d::Identity();
}

Whitening whitening_of(std::span<const Measurement> points, const std::optional<MeasurementNoise>& noise) {
  const auto stated = [](const Measurement& m) { return m.sigma_mm.has_value(); };
  if (!points.empty() && std::ranges::all_of(points, stated)) return by_stated_sigma(points);
  if (noise) return by_model(points, *noise);
  return {};
}

namespace {

/// The numbers of the poses, shuffled.
std::vector<std::size_t> shuffled_poses(int poses, std::uint64_t seed) {
  std::vector<std::size_t> shuffled(static_cast<std::size_t>(poses));
  std::iota(shuffled.begin(), shuffled.end(), std::size_t{0});
  Random random(seed);
  for (std::size_t i = shuffled.size(); i-- > 1;) std::swap(shuffled[i], shuffled[random.next() % (i + 1)]);
  return shuffled;
}

/// Marks every point by its pose: `set_of` gives the set of the pose at a place of the shuffled order.
template <typename SetOf>
void mark_poses(MeasurementData& data, std::uint64_t seed, SetOf set_of) {
  const std::vector<int> pose_of_point = pose_numbers(data.points);
  const std::vector<std::size_t> shuffled = shuffled_poses(count_poses(data.points), seed);
  std::vector<PoseSet> set_of_pose(shuffled.size());
  for (std::size_t place = 0; place < shuffled.size(); ++place) set_of_pose[shuffled[place]] = set_of(place);
  for (std::size_t i = 0; i < data.points.size(); ++i)
    data.points[i].set = set_of_pose[static_cast<std::size_t>(pose_of_point[i])];
}

}  // namespace

void split_poses(MeasurementData& data, double fraction, std::uint64_t seed) {
  const auto identify = static_cast<std::size_t>(std::llround(fraction * count_poses(data.points)));
  mark_poses(data, seed,
             [=](std::size_t place) { return place < identify ? PoseSet::Identify : PoseSet::Validate; });
}

void hold_out_fold(MeasurementData& data, int folds, int fold, std::uint64_t seed) {
  assert(folds >= 2 && fold >= 0 && fold < folds);
  mark_poses(data, seed, [=](std::size_t place) {
    const bool held_out = place % static_cast<std::size_t>(folds) == static_cast<std::size_t>(fold);
    return held_out ? PoseSet::Validate : PoseSet::Identify;
  });
}

}  // namespace truepose
