#include "core/planning/capsule.hpp"

#include <algorithm>

namespace truepose {
namespace {

// A segment below this length is a point: its direction is rounding.
constexpr double kPoint_mm2 = 1e-12;

double share(double part, double whole) { return std::clamp(part / whole, 0.0, 1.0); }

}  // namespace

double distance_mm(const Capsule& a, const Capsule& b) {
  const Eigen::Vector3d along_a = a.to_mm - a.from_mm, along_b = b.to_mm - b.from_mm;
  const Eigen::Vector3d between = a.from_mm - b.from_mm;
  const double aa = along_a.squaredNorm(), bb = along_b.squaredNorm(), ab = along_a.dot(along_b);
  const double a_between = along_a.dot(between), b_between = along_b.dot(between);

  // The nearest points, as shares s and t of the segments: s for the endless lines, t for that s, and s
  // anew where t had to be drawn into its segment. Parallel lines are as near everywhere: s = 0 serves.
  double s = 0, t = 0;
  if (bb <= kPoint_mm2) {
    s = aa <= kPoint_mm2 ? 0 : share(-a_between, aa);
  } else {
    const double across = aa * bb - ab * ab;
    if (aa > kPoint_mm2 && across > kPoint_mm2 * aa * bb) s = share(ab * b_between - a_between * bb, across);
    t = (ab * s + b_between) / bb;
    if (t < 0 || t > 1) {
      t = std::clamp(t, 0.0, 1.0);
      s = aa <= kPoint_mm2 ? 0 : share(ab * t - a_between, aa);
    }
  }
  return (between + s * along_a - t * along_b).norm() - a.radius_mm - b.radius_mm;
}

}  // namespace truepose
