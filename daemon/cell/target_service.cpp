#include "daemon/cell/target_service.hpp"

#include <utility>

#include "config/cell_setup.hpp"
#include "core/arm/joint_units.hpp"
#include "core/compensate/nominal_inverse.hpp"
#include "core/compensate/target_compensation.hpp"
#include "core/math/angles.hpp"

namespace truepose::daemon {

using control::ErrorCode;
using control::RpcError;

namespace {

using Solved = std::expected<CompensatedTarget, std::string>;

Eigen::Isometry3d pose_of(const rpc::PoseRow& row) { return pose_from_kuka(row.head<3>(), row.tail<3>()); }

std::unexpected<RpcError> bad_row(const char* list, std::size_t row, const std::string& why) {
  return rpc::refused(std::string{list} + "[" + std::to_string(row) + "]", why);
}

/// Targets of targets.compensate: joints of the nominal arm, or poses of the tool, without one of the flange.
class Targets {
 public:
  Targets(const config::CellConfig& config, const config::CorrectedArm& real, const Eigen::Isometry3d& X_TF)
      : nominal_{config.robot.model},
        X_TF_{X_TF},
        inverse_{nominal_, std::nullopt},
        compensation_{nominal_, real.robot, config::compensation_options(config)},
        p_F_mm_{real.p_F_mm} {}

  Solved solve(const JointVector& q) { return in_words(compensation_.at_joints(q, p_F_mm_)); }
  Solved solve(const rpc::PoseRow& pose) {
    const Eigen::Isometry3d X_BF = pose_of(pose) * X_TF_;
    const auto q = inverse_.at_pose(X_BF);
    if (!q) return std::unexpected(q.error());
    return in_words(compensation_.at_pose(X_BF, *q, p_F_mm_));
  }

 private:
  Solved in_words(const TargetCompensation::Result& result) const {
    if (result) return *result;
    return std::unexpected(described(result.error(), nominal_));
  }

  const RobotModel& nominal_;
  Eigen::Isometry3d X_TF_;
  NominalInverse inverse_;
  TargetCompensation compensation_;
  Eigen::Vector3d p_F_mm_;
};

}  // namespace

Joints joints_given(const std::vector<std::vector<double>>& rows, const RobotModel& nominal) {
  const std::size_t count = nominal.joints.size();
  std::vector<JointVector> joints;
  for (const std::vector<double>& row : rows) {
    if (row.size() != count)
      return bad_row("joints", joints.size(),
                     "expected " + std::to_string(count) + " numbers, found " + std::to_string(row.size()));
    joints.push_back(joints_from(row, nominal));
  }
  return joints;
}

Joints joints_at(const std::vector<rpc::PoseRow>& poses, const RobotModel& nominal) {
  NominalInverse inverse(nominal, std::nullopt);
  std::vector<JointVector> joints;
  for (const rpc::PoseRow& row : poses) {
    const auto q = inverse.at_pose(pose_of(row));
    if (!q) return bad_row("poses", joints.size(), "cannot be reached: " + q.error());
    joints.push_back(*q);
  }
  return joints;
}

Reply<rpc::TargetsCompensate> TargetService::compensate(rpc::TargetsCompensate request) {
  const RobotModel& nominal = parts_.config.robot.model;
  const config::ToolFile* const known = request.tool ? models_.tools().of(*request.tool) : nullptr;
  // A copy: while this waits for the model another may come into use.
  const std::optional<config::ToolFile> tool = known ? std::optional{*known} : std::nullopt;
  const LinkMass* load = config::load_of(parts_.config, request.tool);
  const std::string refused = request.tool ? models_.tools().refusal(*request.tool) : "";
  if (!refused.empty()) co_return rpc::refused("tool", refused);
  if (request.tool && !tool && !load)
    co_return rpc::refused(
        "tool",
        "no tool of this number was measured and taken into use, and the cell file names no load of it");
  LinkMass payload;
  for (const Eigen::Vector4d& row : request.payload) {
    payload = {row[0], row.tail<3>()};
    load = &payload;
  }
  if (request.joints.empty() == request.poses.empty())
    co_return rpc::refused("joints", "give exactly one of joints and poses");
  const Joints joints = joints_given(request.joints, nominal);
  if (!joints) co_return std::unexpected(joints.error());
  auto found = co_await models_.find_checked(request.model_id.value_or(""));
  if (!found) co_return std::unexpected(found.error());

  const auto arm =
      config::corrected_arm(parts_.config, found->checked->file.cell, tool ? &*tool : nullptr, load);
  if (!arm) co_return std::unexpected(RpcError{ErrorCode::WrongState, arm.error()});

  const Eigen::Isometry3d X_TF = tool ? inverse_of(tool->X_controller) : Eigen::Isometry3d::Identity();
  auto job = [config = parts_.config, joints = *joints, poses = request.poses, arm = *arm, X_TF] {
    Targets targets{config, arm, X_TF};
    std::vector<Solved> solved;
    for (const JointVector& q : joints) solved.push_back(targets.solve(q));
    for (const rpc::PoseRow& pose : poses) solved.push_back(targets.solve(pose));
    return solved;
  };
  const auto solved = co_await parts_.compute_thread.ask(job);
  rpc::TargetsCompensate::Result result;
  for (const Solved& target : solved) {
    if (!target)
      co_return bad_row(request.poses.empty() ? "joints" : "poses", result.joints.size(), target.error());
    result.joints.push_back(in_deg_mm(target->q, nominal));
    result.residual_mm.push_back(target->residual_mm);
    result.residual_deg.push_back(target->residual_rad * kDegPerRad);
    result.iterations.push_back(target->iterations);
    result.damped.push_back(target->damped);
  }
  co_return result;
}

}  // namespace truepose::daemon
