#include "daemon/cell/target_service.hpp"

#include <utility>

#include "config/cell_setup.hpp"
#include "core/arm/joint_units.hpp"
#include "core/compensate/nominal_inverse.hpp"
#include "core/compensate/target_compensation.hpp"
#include "core/math/angles.hpp"
#include "proto/record/arm_document.hpp"

namespace truepose::daemon {

namespace json = boost::json;
using control::ErrorCode;
using control::RpcError;

namespace {

constexpr std::size_t kMostRows = 200;

using Row = std::vector<double>;
using Solved = std::expected<CompensatedTarget, std::string>;

Eigen::Isometry3d pose_of(const Row& row) {
  return pose_from_kuka({row[0], row[1], row[2]}, {row[3], row[4], row[5]});
}

LinkMass payload_of(const Row& row) { return {row[0], {row[1], row[2], row[3]}}; }

RpcError bad_row(const char* list, std::size_t row, const std::string& why) {
  const std::string key = std::string{"params."} + list + "[" + std::to_string(row) + "]";
  return {ErrorCode::InvalidParams, key + ": " + why, key};
}

/// Rows of targets.compensate: joints of the nominal arm, or poses of the tool, without one of the flange.
class TargetRows {
 public:
  TargetRows(const config::CellConfig& config, const config::CorrectedArm& real,
             const Eigen::Isometry3d& X_TF)
      : nominal_{config.robot.model},
        X_TF_{X_TF},
        inverse_{nominal_, std::nullopt},
        compensation_{nominal_, real.robot, config::compensation_options(config)},
        p_F_mm_{real.p_F_mm} {}

  Solved solve(const Row& row, bool is_pose) {
    if (!is_pose) return in_words(compensation_.at_joints(joints_from(row, nominal_), p_F_mm_));
    const Eigen::Isometry3d X_BF = pose_of(row) * X_TF_;
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

json::object solved_json(const std::vector<Solved>& solved, const RobotModel& nominal) {
  json::array joints, residual_mm, residual_deg, iterations, damped;
  for (const Solved& target : solved) {
    joints.push_back(record::joints_json(target->q, nominal));
    residual_mm.emplace_back(target->residual_mm);
    residual_deg.emplace_back(target->residual_rad * kDegPerRad);
    iterations.emplace_back(target->iterations);
    damped.emplace_back(target->damped);
  }
  return {{"joints", std::move(joints)},
          {"residual_mm", std::move(residual_mm)},
          {"residual_deg", std::move(residual_deg)},
          {"iterations", std::move(iterations)},
          {"damped", std::move(damped)}};
}

}  // namespace

std::expected<std::vector<JointVector>, RpcError> joints_at(const std::vector<Row>& poses,
                                                            const RobotModel& nominal) {
  NominalInverse inverse(nominal, std::nullopt);
  std::vector<JointVector> joints;
  for (const Row& row : poses) {
    const auto q = inverse.at_pose(pose_of(row));
    if (!q) return std::unexpected(bad_row("poses", joints.size(), "cannot be reached: " + q.error()));
    joints.push_back(*q);
  }
  return joints;
}

MethodReply TargetService::compensate(json::object params) {
  const RobotModel& nominal = parts_.config.robot.model;
  control::ParamReader read{params};
  auto joints = read.rows("joints", static_cast<std::size_t>(nominal.joint_count()), kMostRows);
  auto poses = read.rows("poses", 6, kMostRows);
  const std::string id = read.id("model_id").value_or("");
  const auto number = read.integer("tool", 1, 1000);
  const std::optional<int> named = number ? std::optional{static_cast<int>(*number)} : std::nullopt;
  const config::ToolFile* const known = named ? models_.tools().of(*named) : nullptr;
  // A copy: while this waits for the model another may come into use.
  const std::optional<config::ToolFile> tool = known ? std::optional{*known} : std::nullopt;
  const LinkMass* load = config::load_of(parts_.config, named);
  const std::string refused = named ? models_.tools().refusal(*named) : "";
  if (!refused.empty()) read.fail("tool", refused);
  if (refused.empty() && named && !tool && !load)
    read.fail(
        "tool",
        "no tool of this number was measured and taken into use, and the cell file names no load of it");
  const auto carried = read.rows("payload", 4, 1);
  const LinkMass payload = carried ? payload_of(carried->front()) : LinkMass{};
  if (carried) load = &payload;
  if (payload.mass_kg < 0) read.fail("payload", "expected a mass of 0 or more");
  if (joints.has_value() == poses.has_value()) read.fail("joints", "give exactly one of joints and poses");
  if (auto wrong = read.finish()) co_return std::unexpected(*wrong);
  auto found = co_await models_.find_checked(id);
  if (!found) co_return std::unexpected(found.error());

  const auto arm =
      config::corrected_arm(parts_.config, found->checked->file.cell, tool ? &*tool : nullptr, load);
  if (!arm) co_return std::unexpected(RpcError{ErrorCode::WrongState, arm.error()});

  const bool is_pose = poses.has_value();
  const Eigen::Isometry3d X_TF = tool ? inverse_of(tool->X_controller) : Eigen::Isometry3d::Identity();
  auto job = [config = parts_.config, is_pose, rows = is_pose ? *poses : *joints, arm = *arm, X_TF] {
    TargetRows targets{config, arm, X_TF};
    std::vector<Solved> solved;
    for (const Row& row : rows) solved.push_back(targets.solve(row, is_pose));
    return solved;
  };
  auto solved = co_await parts_.compute_thread.ask(job);
  for (std::size_t row = 0; row < solved.size(); ++row) {
    if (!solved[row])
      co_return std::unexpected(bad_row(is_pose ? "poses" : "joints", row, solved[row].error()));
  }
  co_return solved_json(solved, nominal);
}

}  // namespace truepose::daemon
