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

Eigen::Isometry3d flange_pose(const Row& row) {
  return pose_from_kuka({row[0], row[1], row[2]}, {row[3], row[4], row[5]});
}

RpcError bad_row(const char* list, std::size_t row, const std::string& why) {
  const std::string key = std::string{"params."} + list + "[" + std::to_string(row) + "]";
  return {ErrorCode::InvalidParams, key + ": " + why, key};
}

/// Rows of targets.compensate: joints of the nominal arm, or poses of the flange.
class TargetRows {
 public:
  TargetRows(const config::CellConfig& config, const CalibratedCell& real)
      : nominal_{config.robot.model},
        inverse_{nominal_, std::nullopt},
        compensation_{nominal_, real.robot, config::compensation_options(config)},
        p_F_mm_{config::kept_point_mm(config, real)} {}

  Solved solve(const Row& row, bool is_pose) {
    if (!is_pose) return in_words(compensation_.at_joints(joints_from(row, nominal_), p_F_mm_));
    const Eigen::Isometry3d X_BF = flange_pose(row);
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
    const auto q = inverse.at_pose(flange_pose(row));
    if (!q) return std::unexpected(bad_row("poses", joints.size(), "cannot be reached"));
    joints.push_back(*q);
  }
  return joints;
}

MethodReply TargetService::compensate(json::object params) {
  const RobotModel& nominal = parts_.config.robot.model;
  control::ParamReader read{params};
  auto joints = read.rows("joints", static_cast<std::size_t>(nominal.joint_count()), kMostRows);
  auto poses = read.rows("poses", 6, kMostRows);
  const std::string id = read.text("model_id").value_or("");
  if (joints.has_value() == poses.has_value()) read.fail("joints", "give exactly one of joints and poses");
  if (auto wrong = read.finish()) co_return std::unexpected(*wrong);
  auto found = co_await models_.find_checked(id);
  if (!found) co_return std::unexpected(found.error());

  const bool is_pose = poses.has_value();
  auto job = [config = parts_.config, is_pose, rows = is_pose ? *poses : *joints,
              cell = found->checked->file.cell] {
    TargetRows targets{config, cell};
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
