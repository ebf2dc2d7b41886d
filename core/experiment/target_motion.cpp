#include "core/experiment/target_motion.hpp"

#include "core/compensation/target_compensation.hpp"
#include "core/compensation/tracker_loop.hpp"
#include "core/kinematics/angles.hpp"

namespace truepose {

std::optional<JointVector> joints_for_reflector(const CalibratedCell& cell, const Eigen::Vector3d& p_WS_mm,
                                                const JointVector& q_seed,
                                                const ApproachDirections& directions) {
  const TargetCompensation arm{cell.robot, cell.robot, {.approach = directions}};
  const auto found =
      arm.at_position(inverse_of(cell.base.isometry()) * p_WS_mm, q_seed, cell.reflectors.front().p_FS_mm);
  if (!found) return std::nullopt;
  return found->q;
}

Eigen::Vector3d approach_with_tracker(TrueArm& arm, const CalibratedCell& cell,
                                      const Eigen::Vector3d& p_WS_mm, const JointVector& q,
                                      const TrackerReadings& readings, Random& random) {
  TrackerLoop loop{cell, p_WS_mm, q, {.rounds = readings.rounds, .tolerance_mm = 0}};
  while (!loop.end()) {
    Eigen::Vector3d reading = arm.p_WS_mm(loop.q());
    for (double& axis : reading) axis += readings.noise_mm * random.normal();
    loop.add(reading);
    arm.move_to(loop.q());
  }
  return arm.p_WS_mm(loop.q());
}

}  // namespace truepose
