#include "core/fit/warm_up.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <map>

#include "core/data/measured_time.hpp"
#include "core/math/dense_algebra.hpp"

namespace truepose {
namespace {

constexpr double kOwnShare = 0.5;  // of the warmth's variance: so much may the joints explain

std::optional<double> seconds_of(const Measurement& point) {
  const auto time = measured_time(point.time);
  return time ? std::optional{time->seconds} : std::nullopt;
}

std::vector<Measurement> in_order(std::span<const Measurement> points) {
  std::vector<Measurement> ordered;
  std::ranges::copy_if(points, std::back_inserter(ordered), &Measurement::in_order);
  return ordered;
}

/// When each point was measured, in the clock's unit; nothing where nothing says so.
std::vector<std::optional<double>> moments(bool by_order, std::span<const Measurement> points) {
  const std::vector<int> poses = by_order ? pose_numbers(in_order(points)) : std::vector<int>{};
  std::vector<std::optional<double>> moments;
  std::size_t ordered = 0;
  for (const Measurement& point : points) {
    if (!by_order)
      moments.push_back(seconds_of(point));
    else if (point.in_order)
      moments.emplace_back(poses[ordered++]);
    else
      moments.emplace_back();
  }
  return moments;
}

/// A parabola in each joint.
Eigen::RowVectorXd joint_features(const JointVector& q) {
  Eigen::RowVectorXd row(2 * q.size() + 1);
  row << q.transpose(), q.transpose().cwiseAbs2(), 1;
  return row;
}

}  // namespace

bool has_times(std::span<const Measurement> points) {
  std::optional<double> first;
  for (const Measurement& point : points) {
    const std::optional<double> moment = seconds_of(point);
    if (moment && *moment != first.value_or(*moment)) return true;
    if (!first) first = moment;
  }
  return false;
}

MeasurementData with_warmth_by(const WarmUpClock& clock, MeasurementData data) {
  const auto moment = moments(clock.by_order, data.points);
  std::map<int, double> start;
  for (std::size_t i = 0; i < data.points.size(); ++i) {
    if (!moment[i]) continue;
    const auto [first, is_new] = start.emplace(data.points[i].station, *moment[i]);
    first->second = std::min(first->second, *moment[i]);
  }
  for (std::size_t i = 0; i < data.points.size(); ++i) {
    Measurement& point = data.points[i];
    point.temperature_c.clear();
    if (!moment[i]) continue;
    const double warm = -std::expm1((start.at(point.station) - *moment[i]) / clock.constant);
    point.temperature_c.assign(static_cast<std::size_t>(point.q.size()), warm);
  }
  return data;
}

std::vector<WarmUpClock> warm_up_clocks(const MeasurementData& data) {
  std::vector<WarmUpClock> clocks;
  if (has_times(data.points)) {
    for (const int minutes : {5, 10, 15, 20, 30, 45, 60, 90, 120})
      clocks.push_back({.constant = 60.0 * minutes});
    return clocks;
  }
  const int poses = count_poses(in_order(data.points));
  for (const double share : {1.0 / 16, 1.0 / 11, 1.0 / 8, 1.0 / 6, 1.0 / 4, 1.0 / 3, 1.0 / 2, 3.0 / 4, 1.0})
    clocks.push_back({.by_order = true, .constant = share * poses});
  return clocks;
}

bool follows_the_joints(std::span<const Measurement> points) {
  const auto count = static_cast<Eigen::Index>(points.size());
  const Eigen::Index unknowns = joint_features(points.front().q).size();
  if (count < 2 * unknowns) return true;
  Eigen::MatrixXd A(count, unknowns);
  Eigen::VectorXd warmth(count);
  for (Eigen::Index i = 0; i < count; ++i) {
    const Measurement& point = points[static_cast<std::size_t>(i)];
    A.row(i) = joint_features(point.q);
    warmth[i] = point.temperature_c.empty() ? 0 : point.temperature_c.front();
  }
  warmth.array() -= warmth.mean();
  const Svd svd = thin_svd(A);
  const double explained2 = transposed_times(svd.U, warmth).squaredNorm(), all2 = warmth.squaredNorm();
  // By chance alone every unknown explains its share.
  const auto left = static_cast<double>(count - unknowns), of = static_cast<double>(count - 1);
  return (all2 - explained2) / left < kOwnShare * all2 / of;
}

}  // namespace truepose
