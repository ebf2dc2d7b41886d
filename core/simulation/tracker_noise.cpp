#include "core/simulation/tracker_noise.hpp"

#include <Eigen/Geometry>

namespace truepose {

Eigen::Vector3d noisy_reading(const Eigen::Vector3d& p_true_mm, const TrackerNoiseModel& model,
                              Random& random) {
  const double distance_m = p_true_mm.norm() / 1000.0;
  const double range_mm = model.range_mm + model.range_mm_per_m * distance_m;
  const double transverse_mm = model.transverse_mm + model.transverse_mm_per_m * distance_m;

  const Eigen::Vector3d along =
      distance_m > 0 ? Eigen::Vector3d{p_true_mm.normalized()} : Eigen::Vector3d::UnitX();
  const Eigen::Vector3d across = along.unitOrthogonal();
  // One draw a line: the order in which a sum's terms are evaluated is the compiler's choice.
  const double e_range_mm = range_mm * random.normal();
  const double e_across_mm = transverse_mm * random.normal();
  const double e_third_mm = transverse_mm * random.normal();
  return p_true_mm + e_range_mm * along + e_across_mm * across + e_third_mm * along.cross(across);
}

}  // namespace truepose
