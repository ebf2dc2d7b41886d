#include "core/compensate/nominal_inverse.hpp"

#include "core/math/random.hpp"

namespace truepose {
namespace {

JointVector middle_of_ranges(const RobotModel& robot) {
  JointVector q(robot.joint_count());
  for (int i = 0; i < robot.joint_count(); ++i) {
    const Joint& joint = robot.joints[static_cast<std::size_t>(i)];
    q[i] = (joint.min + joint.max) / 2;
  }
  return q;
}

JointVector anywhere(const RobotModel& robot, Random& random) {
  JointVector q(robot.joint_count());
  for (int i = 0; i < robot.joint_count(); ++i) {
    const Joint& joint = robot.joints[static_cast<std::size_t>(i)];
    q[i] = random.uniform(joint.min, joint.max);
  }
  return q;
}

}  // namespace

NominalInverse::NominalInverse(const RobotModel& robot, const std::optional<JointVector>& q_near)
    : robot_(robot),
      itself_(robot, robot, {.approach = {}}),
      by_status_(StatusTurnInverse::of(robot)),
      q_near_(q_near ? *q_near : middle_of_ranges(robot)) {
  if (auto solver = SphericalWristInverse::of(robot)) closed_form_ = *solver;
}

NominalInverse::Result NominalInverse::remembered(Result q) {
  if (q) q_near_ = *q;
  return q;
}

template <typename Solve>
NominalInverse::Result NominalInverse::from_several_starts(Solve solve) const {
  constexpr int kStarts = 50;
  Random random(0);
  JointVector seed = q_near_;
  for (int i = 0; i < kStarts; ++i) {
    const auto result = solve(seed);
    if (result && within_limits(robot_, result->q)) return result->q;
    seed = anywhere(robot_, random);
  }
  return std::unexpected("no joint positions within the limits found from " + std::to_string(kStarts) +
                         " starts");
}

NominalInverse::Result NominalInverse::at_pose(const Eigen::Isometry3d& X_BF) {
  if (closed_form_) return remembered(closed_form_->nearest(X_BF, q_near_));
  return remembered(
      from_several_starts([&](const JointVector& seed) { return inverse_near(robot_, X_BF, seed); }));
}

NominalInverse::Result NominalInverse::at_pose(const Eigen::Isometry3d& X_BF, std::optional<int> status,
                                               std::optional<int> turn) {
  if (!by_status_) return std::unexpected("s and t cannot be used with this arm: " + by_status_.error());
  return remembered(by_status_->solve(X_BF, status, turn, q_near_));
}

NominalInverse::Result NominalInverse::at_position(const Eigen::Vector3d& p_B_mm,
                                                   const Eigen::Vector3d& p_F_mm) {
  return remembered(from_several_starts(
      [&](const JointVector& seed) { return itself_.at_position(p_B_mm, seed, p_F_mm); }));
}

}  // namespace truepose
