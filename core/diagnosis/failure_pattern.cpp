#include "core/diagnosis/failure_pattern.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <numeric>
#include <vector>

#include "core/arm/joint_units.hpp"
#include "core/math/statistics.hpp"

namespace truepose {
namespace {

constexpr std::size_t kFewestPoints = 15;
constexpr double kStandsOut = 2.5;  // times: thirds of points that are missed alike differ by less

std::string whole(double value) { return std::to_string(std::lround(value)); }

/// Something by which the points can be put in order.
struct Scale {
  std::string name, unit;
  std::function<double(const Measurement&)> value;
};

std::vector<Scale> scales_of(const RobotModel& arm) {
  std::vector<Scale> scales{{"row", "", [](const Measurement& m) { return m.row; }}};
  for (Eigen::Index i = 0; i < arm.joint_count(); ++i) {
    const Joint& joint = arm.joints[static_cast<std::size_t>(i)];
    scales.push_back({"joint " + std::to_string(i + 1), " " + std::string{unit_name(joint)},
                      [i, unit = unit_of(joint)](const Measurement& m) { return m.q[i] / unit; }});
  }
  for (const int axis : {0, 1, 2}) {
    scales.push_back(
        {std::string{"xyz"[axis]}, " mm", [axis](const Measurement& m) { return m.p_WS_mm[axis]; }});
  }
  return scales;
}

struct Pattern {
  double contrast = kStandsOut;
  std::string words;
};

/// The thirds of the points along a scale, each against the rest.
void look_along(const Scale& scale, std::span<const Measurement> points, std::span<const double> miss_mm,
                Pattern& best) {
  std::vector<std::size_t> order(points.size());
  std::iota(order.begin(), order.end(), 0);
  const auto value = [&](std::size_t k) { return scale.value(points[k]); };
  std::ranges::stable_sort(order, {}, value);
  const std::array<std::size_t, 4> ends{0, points.size() / 3, 2 * points.size() / 3, points.size()};
  for (std::size_t third = 0; third < 3; ++third) {
    std::vector<double> inside, outside;
    for (std::size_t n = 0; n < order.size(); ++n)
      (n >= ends[third] && n < ends[third + 1] ? inside : outside).push_back(miss_mm[order[n]]);
    const double contrast = median(inside) / median(outside);
    if (!(contrast > best.contrast)) continue;
    const std::string low = whole(value(order[ends[third]])), high = whole(value(order[ends[third + 1] - 1]));
    best = {contrast, scale.name + " from " + low + " to " + high + scale.unit + ": " +
                          whole(median(inside)) + " mm, elsewhere " + whole(median(outside)) + " mm"};
  }
}

}  // namespace

std::string failure_pattern(const RobotModel& arm, std::span<const Measurement> points,
                            std::span<const double> miss_mm) {
  Pattern best;
  if (points.size() < kFewestPoints) return best.words;
  for (const Scale& scale : scales_of(arm)) look_along(scale, points, miss_mm, best);
  return best.words;
}

}  // namespace truepose
