#include "daemon/campaign/arm_check.hpp"

#include "core/formatted.hpp"

namespace truepose::daemon {

namespace {

DeviceError wrong_arm(const std::string& why, const std::string& what_to_do) {
  return {.remedy = Remedy::WrongArm, .detail = why, .what_to_do = what_to_do};
}

std::string probable_causes(const std::vector<JointMistake>& mistakes) {
  if (mistakes.empty()) return " (are tool and base 0?)";
  std::string text;
  for (const JointMistake& mistake : mistakes) text += (text.empty() ? ": " : ", or ") + mistake.what;
  return text;
}

}  // namespace

std::expected<void, DeviceError> check_type(const config::RobotConfig& robot,
                                            const drivers::RobotIdentity& identity,
                                            const drivers::RobotState& state) {
  if (identity.model.find(robot.expect_model) == std::string::npos) {
    return std::unexpected(wrong_arm(
        "wrong arm: the controller says " + identity.model + ", the cell expects " + robot.expect_model,
        "connect that arm, or correct robot.expect_model and robot.file and restart trueposed"));
  }
  if (state.q.size() != robot.model.joint_count()) {
    return std::unexpected(wrong_arm("wrong arm: the controller reports " + std::to_string(state.q.size()) +
                                         " joints, " + robot.model.name + " has " +
                                         std::to_string(robot.model.joint_count()),
                                     "correct robot.file and restart trueposed"));
  }
  return {};
}

std::expected<void, DeviceError> check_poses(const config::RobotConfig& robot,
                                             std::span<const ControllerPose> poses) {
  const double off_mm = largest_deviation_mm(robot.model, poses);
  // Written so that a NaN is refused as well.
  if (off_mm <= robot.max_fk_deviation_mm) return {};
  return std::unexpected(
      wrong_arm("wrong arm or wrong robot file: the controller's flange pose and the kinematics of " +
                    robot.model.name +
                    formatted(" are %.2f mm apart, allowed are %.2f mm", off_mm, robot.max_fk_deviation_mm) +
                    probable_causes(joint_mistakes(robot.model, poses, robot.max_fk_deviation_mm)),
                "correct robot.file and restart trueposed, or set tool 0 and base 0"));
}

std::expected<void, DeviceError> check_arm(const config::RobotConfig& robot,
                                           const drivers::RobotIdentity& identity,
                                           const drivers::RobotState& state) {
  const auto type = check_type(robot, identity, state);
  if (!type) return type;
  const ControllerPose here{state.q, state.X_BF_reported};
  return check_poses(robot, {&here, 1});
}

bool is_undecided(const config::RobotConfig& robot, std::span<const ControllerPose> poses) {
  const double most_mm = robot.max_fk_deviation_mm;
  if (largest_deviation_mm(robot.model, poses) <= most_mm) return false;
  const auto mistakes = joint_mistakes(robot.model, poses, most_mm);
  return !mistakes.empty() && mistakes.front().joint != mistakes.back().joint;
}

std::string other_arm(std::string_view what, const std::string& serial, const std::string& here) {
  if (serial == here) return {};
  return std::string{what} + " belongs to arm " + serial + ", not to " + here;
}

}  // namespace truepose::daemon
