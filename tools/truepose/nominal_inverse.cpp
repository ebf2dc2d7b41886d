#include "tools/truepose/nominal_inverse.hpp"

#include "core/compensation/pose_inverse.hpp"
#include "core/random.hpp"

namespace truepose::tools {

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

NominalInverse::NominalInverse(const RobotModel& robot) : robot_(robot), q_near_(middle_of_ranges(robot)) {
  if (auto solver = SphericalWristInverse::of(robot)) closed_form_ = *solver;
}

std::expected<JointVector, std::string> NominalInverse::next(const Eigen::Isometry3d& X_BF) {
  auto q = closed_form_ ? closed_form_->nearest(X_BF, q_near_) : by_newton(X_BF);
  if (q) q_near_ = *q;
  return q;
}

std::expected<JointVector, std::string> NominalInverse::by_newton(const Eigen::Isometry3d& X_BF) const {
  constexpr int kStarts = 50;
  Random random(0);
  JointVector seed = q_near_;
  for (int i = 0; i < kStarts; ++i) {
    const auto result = inverse_near(robot_, X_BF, seed);
    if (result && within_limits(robot_, result->q)) return result->q;
    seed = anywhere(robot_, random);
  }
  return std::unexpected("no joint positions within the limits found from " + std::to_string(kStarts) +
                         " starts");
}

}  // namespace truepose::tools
