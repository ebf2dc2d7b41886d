#include "core/change/far_stretch.hpp"

#include <cstddef>
#include <utility>
#include <vector>

#include "core/change/time_evidence.hpp"
#include "core/fit/measurement_model.hpp"

namespace truepose {
namespace {

/// Consecutive points, and those of them that nothing explains.
struct Stretch {
  double points = 0, far = 0, lengths_mm = 0;
  Eigen::Vector3d sum_mm{0, 0, 0};

  void add(const Eigen::Vector3d& error_mm, bool is_far) {
    points += 1;
    if (!is_far) return;
    far += 1;
    lengths_mm += error_mm.norm();
    sum_mm += error_mm;
  }
  /// Nearly all are far, and off in the same way.
  bool moved() const {
    constexpr double kNearlyAll = 2.0 / 3, kSameWay = 0.8;
    return far >= 2 && far >= kNearlyAll * points && sum_mm.norm() > kSameWay * lengths_mm;
  }
  bool stood() const {
    constexpr double kFew = 0.1;
    return far <= kFew * points;
  }
};

/// A moment that parts the far points of a station from the others.
///
/// @param points  of that station
std::optional<Movement> parting(std::span<const Eigen::Vector3d> errors_mm, const std::vector<bool>& is_far,
                                std::span<const std::size_t> points) {
  std::vector<Stretch> from(points.size() + 1);
  for (std::size_t k = points.size(); k-- > 0;) {
    from[k] = from[k + 1];
    from[k].add(errors_mm[points[k]], is_far[points[k]]);
  }
  std::optional<Movement> found;
  double most = 0;
  Stretch before;
  for (std::size_t k = 1; k < points.size(); ++k) {
    before.add(errors_mm[points[k - 1]], is_far[points[k - 1]]);
    for (const auto& [moved, stood] : {std::pair{before, from[k]}, std::pair{from[k], before}}) {
      const double right = moved.far + stood.points - stood.far;
      if (!moved.moved() || !stood.stood() || right <= most) continue;
      most = right;
      found.emplace();
      found->profile = TimeProfile::FarStretch;
      found->first = points[k];
      found->moved_mm = moved.lengths_mm / moved.far;
    }
  }
  return found;
}

}  // namespace

std::optional<Movement> far_stretch(const CalibratedCell& cell, std::span<const Measurement> points,
                                    const std::vector<bool>& is_far) {
  const Eigen::VectorXd f = residuals(cell, points);
  std::vector<Eigen::Vector3d> errors_mm;
  for (std::size_t i = 0; i < points.size(); ++i) errors_mm.push_back(f.segment<3>(row_of(i)));
  for (int station = 0; station < cell.station_count(); ++station) {
    std::vector<std::size_t> seen;
    for (std::size_t i = 0; i < points.size(); ++i)
      if (points[i].station == station) seen.push_back(i);
    auto found = parting(errors_mm, is_far, seen);
    if (!found) continue;
    found->what = {ChangeKind::Base, station};
    return found;
  }
  return std::nullopt;
}

}  // namespace truepose
