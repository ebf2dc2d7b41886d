#include "core/experiment/target_motion.hpp"

#include <Eigen/LU>

#include "core/kinematics/forward.hpp"

namespace truepose {
namespace {

constexpr double kTolerance_mm = 1e-6;
constexpr int kMaxSteps = 20;

/// Smallest joint step that moves the reflector by `missing` (mm, tracker frame).
JointVector smallest_step(const CalibratedCell& cell, const JointVector& q,
                          const Eigen::Vector3d& missing_W) {
  const PoseAndJacobian at = forward_with_jacobian(cell.robot, q);
  const Eigen::Vector3d lever = at.X_BF.linear() * cell.reflectors.front().p_FS_mm;
  Eigen::Matrix<double, 3, Eigen::Dynamic, Eigen::ColMajor, 3, kMaxJoints> J = at.J.topRows<3>();
  for (Eigen::Index i = 0; i < J.cols(); ++i) {
    const Eigen::Vector3d axis = at.J.col(i).tail<3>();
    J.col(i) += axis.cross(lever);
  }
  const Eigen::Vector3d missing_B = cell.base.isometry().linear().transpose() * missing_W;
  const Eigen::Matrix3d JJt = J * J.transpose();
  return J.transpose() * (JJt.inverse() * missing_B);
}

}  // namespace

std::optional<JointVector> joints_for_reflector(const CalibratedCell& cell, const Eigen::Vector3d& p_WS_mm,
                                                const JointVector& q_seed,
                                                const ApproachDirections& directions) {
  JointVector q = q_seed;
  for (int step = 0; step < kMaxSteps; ++step) {
    const Eigen::Vector3d missing = p_WS_mm - cell.predict(q, 0, directions);
    if (missing.norm() < kTolerance_mm) return q;
    q += smallest_step(cell, q, missing);
  }
  return std::nullopt;
}

Eigen::Vector3d approach_with_tracker(TrueArm& arm, const CalibratedCell& cell,
                                      const Eigen::Vector3d& p_WS_mm, JointVector q,
                                      const TrackerLoopOptions& options, Random& random) {
  for (int round = 1; round <= options.rounds; ++round) {
    Eigen::Vector3d reading = arm.p_WS_mm(q);
    for (double& axis : reading) axis += options.tracker_noise_mm * random.normal();
    q += smallest_step(cell, q, (p_WS_mm - reading) / round);
    arm.move_to(q);
  }
  return arm.p_WS_mm(q);
}

}  // namespace truepose
