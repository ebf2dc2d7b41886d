#include "core/compensate/largest_correction.hpp"

#include <algorithm>
#include <cmath>

#include "core/compensate/target_compensation.hpp"
#include "core/math/units.hpp"

namespace truepose {

double largest_correction(const RobotModel& nominal, const CalibratedCell& calibrated,
                          std::span<const JointVector> poses) {
  const CompensationOptions options;
  const TargetCompensation compensation{nominal, calibrated.robot, options};
  const Eigen::Vector3d p_F_mm =
      calibrated.reflectors.empty() ? Eigen::Vector3d(0, 0, 0) : calibrated.reflectors.front().p_FS_mm;
  double largest = 0;
  for (const JointVector& q : poses) {
    const auto target = compensation.at_joints(q, p_F_mm);
    if (!target) return options.largest_correction;
    for (Eigen::Index i = 0; i < q.size(); ++i) {
      const bool turns = nominal.joints[static_cast<std::size_t>(i)].type == JointType::Revolute;
      largest = std::max(largest, std::abs(target->q[i] - q[i]) * (turns ? 1 : kMetresPerMm));
    }
  }
  return largest;
}

}  // namespace truepose
