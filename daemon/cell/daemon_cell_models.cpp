#include <algorithm>
#include <utility>

#include "config/cell_setup.hpp"
#include "config/model_file.hpp"
#include "core/arm/joint_units.hpp"
#include "core/compensate/nominal_inverse.hpp"
#include "core/compensate/target_compensation.hpp"
#include "core/math/angles.hpp"
#include "core/math/statistics.hpp"
#include "daemon/cell/campaign_run.hpp"
#include "daemon/cell/cell_json.hpp"
#include "daemon/cell/page.hpp"
#include "daemon/log/log.hpp"
#include "proto/control/json_text.hpp"
#include "proto/control/param_reader.hpp"
#include "proto/record/arm_document.hpp"

// The model.* methods and targets.compensate.

namespace truepose::daemon {

namespace asio = boost::asio;
namespace json = boost::json;
using control::ErrorCode;
using control::RpcError;

namespace {

using Solved = std::expected<CompensatedTarget, std::string>;

/// Rows of targets.compensate: joints of the nominal arm, or poses of the flange.
class TargetRows {
 public:
  TargetRows(const config::CellConfig& config, const CalibratedCell& real)
      : nominal_{config.robot.model},
        inverse_{nominal_, std::nullopt},
        compensation_{nominal_, real.robot, config::compensation_options(config)},
        p_F_mm_{config::kept_point_mm(config, real)} {}

  Solved solve(const std::vector<double>& row, bool is_pose) {
    return is_pose ? at_pose(row) : told(compensation_.at_joints(joints_from(row, nominal_), p_F_mm_));
  }

 private:
  Solved at_pose(const std::vector<double>& row) {
    const Eigen::Isometry3d X_BF = pose_from_kuka({row[0], row[1], row[2]}, {row[3], row[4], row[5]});
    const auto q = inverse_.at_pose(X_BF);
    if (!q) return std::unexpected(q.error());
    return told(compensation_.at_pose(X_BF, *q, p_F_mm_));
  }

  Solved told(const TargetCompensation::Result& result) const {
    if (result) return *result;
    return std::unexpected(described(result.error(), nominal_));
  }

  const RobotModel& nominal_;
  NominalInverse inverse_;
  TargetCompensation compensation_;
  Eigen::Vector3d p_F_mm_;
};

}  // namespace

asio::awaitable<StoreResult<void>> DaemonCell::load_active_model() {
  auto found = co_await find_checked("");
  if (!found) co_return std::unexpected(found.error());
  active_.reset();
  if (!*found || !(*found)->checked) {
    parts_.stream.use_no_model();
    judge_active_model(*found ? (*found)->checked.error() : "");
    co_return StoreResult<void>{};
  }
  const StoredModel& model = *(*found)->checked;
  active_ = Active{(*found)->record, model.file.cell, config::drift_reference(model.file)};
  parts_.stream.use_model(active_->cell.robot, ++model_number_,
                          config::kept_point_mm(parts_.config, active_->cell));
  if (!model.unchecked.empty()) log_warning(model.unchecked);
  judge_active_model("");
  co_return StoreResult<void>{};
}

void DaemonCell::judge_active_model(const std::string& sentence) {
  if (model_fault_) publish_fault(*std::exchange(model_fault_, std::nullopt), false);
  if (sentence.empty()) return;
  log_error(sentence);
  model_fault_ = Fault{"E_MODEL", "error", sentence, control::rfc3339(parts_.wall_clock())};
  publish_fault(*model_fault_, true);
}

asio::awaitable<StoreResult<std::optional<DaemonCell::FoundModel>>> DaemonCell::find_checked(std::string id) {
  auto job = [this, id]() -> StoreResult<std::optional<FoundModel>> {
    auto record = id.empty() ? parts_.store.active_model() : parts_.store.model(id);
    if (!record) return std::unexpected(record.error());
    if (!*record) return std::nullopt;
    const auto points = parts_.store.points((*record)->campaign_id);
    if (!points) return std::unexpected(points.error());
    return FoundModel{**record, checked_model(**record, *points, parts_.config)};
  };
  auto found = co_await parts_.store_thread.ask(job);
  co_return found;
}

RpcError DaemonCell::refused_model(const std::string& why_not) const {
  return {ErrorCode::WrongState, why_not, {}, std::string{state()}, allowed_methods(state_)};
}

asio::awaitable<std::expected<ModelRecord, RpcError>> DaemonCell::find_model(std::string id) {
  auto job = [this, id] { return id.empty() ? parts_.store.active_model() : parts_.store.model(id); };
  auto record = co_await parts_.store_thread.ask(job);
  if (!record) co_return std::unexpected(RpcError{ErrorCode::Internal, record.error().detail});
  if (!*record)
    co_return std::unexpected(
        RpcError{ErrorCode::NotFound, id.empty() ? "no model is active" : "no such model"});
  co_return **record;
}

DaemonCell::Reply DaemonCell::model_list(json::object params) {
  control::ParamReader read{params};
  const Page page{read};
  if (auto wrong = read.finish()) co_return std::unexpected(*wrong);
  auto job = [this] { return parts_.store.models(); };
  auto records = co_await parts_.store_thread.ask(job);
  if (!records) co_return std::unexpected(RpcError{ErrorCode::Internal, records.error().detail});
  co_return json::object{{"models", page.of(*records, &model_json)}, {"total", records->size()}};
}

DaemonCell::Reply DaemonCell::model_get(json::object params) {
  control::ParamReader read{params};
  const std::string id = read.text("id").value_or("");
  if (auto wrong = read.finish()) co_return std::unexpected(*wrong);
  auto record = co_await find_model(id);
  if (!record) co_return std::unexpected(record.error());
  json::array parameters;
  const config::ModelFile file = config::parse_model(record->yaml, "model " + record->id);
  for (const IdentifiedParameter& parameter : file.parameters)
    parameters.push_back(parameter_json(parameter));
  co_return json::object{{"model", model_json(*record)}, {"parameters", std::move(parameters)}};
}

DaemonCell::Reply DaemonCell::model_export(json::object params) {
  control::ParamReader read{params};
  const std::string id = read.text("id").value_or("");
  if (auto wrong = read.finish()) co_return std::unexpected(*wrong);
  auto record = co_await find_model(id);
  if (!record) co_return std::unexpected(record.error());
  co_return json::object{{"id", record->id}, {"yaml", record->yaml}};
}

DaemonCell::Reply DaemonCell::model_activate(json::object params) {
  control::ParamReader read{params};
  const std::string id = read.required(read.text("id"), "id");
  if (auto wrong = read.finish()) co_return std::unexpected(*wrong);
  auto found = co_await find_checked(id);
  if (!found) co_return std::unexpected(RpcError{ErrorCode::Internal, found.error().detail});
  if (!*found) co_return std::unexpected(RpcError{ErrorCode::NotFound, "no such model"});
  const ModelRecord& record = (*found)->record;
  std::string why_not;
  if (!improves(record.validation_before_mm, record.validation_after_mm)) {
    why_not = "the model is no better than the nominal arm on validation poses";
  } else if (identities_ && identities_->robot.serial != record.robot_serial) {
    why_not = "the model belongs to arm " + record.robot_serial + ", not to " + identities_->robot.serial;
  } else if (!(*found)->checked) {
    why_not = (*found)->checked.error();
    log_error(why_not);
  }
  if (!why_not.empty()) co_return std::unexpected(refused_model(why_not));
  auto job = [this, id] { return parts_.store.activate_model(id); };
  auto activated = co_await parts_.store_thread.ask(job);
  if (!activated) co_return std::unexpected(RpcError{ErrorCode::Internal, activated.error().detail});
  auto loaded = co_await load_active_model();
  if (!loaded) co_return std::unexpected(RpcError{ErrorCode::Internal, loaded.error().detail});
  if (!active_)
    co_return std::unexpected(refused_model(model_fault_ ? model_fault_->text : "no model is active"));
  publish_model("activated", active_->record);
  co_return model_json(active_->record);
}

DaemonCell::Reply DaemonCell::model_deactivate(json::object params) {
  control::ParamReader read{params};
  if (auto wrong = read.finish()) co_return std::unexpected(*wrong);
  auto job = [this] { return parts_.store.activate_model(""); };
  auto deactivated = co_await parts_.store_thread.ask(job);
  if (!deactivated) co_return std::unexpected(RpcError{ErrorCode::Internal, deactivated.error().detail});
  const std::optional<Active> before = std::exchange(active_, std::nullopt);
  parts_.stream.use_no_model();
  judge_active_model("");
  if (before) publish_model("deactivated", before->record);
  co_return json::object{{"deactivated", before ? json::value(before->record.id) : json::value{}}};
}

DaemonCell::Reply DaemonCell::targets_compensate(json::object params) {
  const RobotModel& nominal = parts_.config.robot.model;
  control::ParamReader read{params};
  auto joints = read.rows("joints", static_cast<std::size_t>(nominal.joint_count()), 200);
  auto poses = read.rows("poses", 6, 200);
  const std::string id = read.text("model_id").value_or("");
  if (joints.has_value() == poses.has_value()) read.fail("joints", "give exactly one of joints and poses");
  if (auto wrong = read.finish()) co_return std::unexpected(*wrong);
  auto found = co_await find_checked(id);
  if (!found) co_return std::unexpected(RpcError{ErrorCode::Internal, found.error().detail});
  if (!*found)
    co_return std::unexpected(
        RpcError{ErrorCode::NotFound, id.empty() ? "no model is active" : "no such model"});
  if (!(*found)->checked) co_return std::unexpected(refused_model((*found)->checked.error()));

  const bool is_pose = poses.has_value();
  auto job = [config = parts_.config, is_pose, rows = is_pose ? *poses : *joints,
              cell = (*found)->checked->file.cell] {
    TargetRows targets{config, cell};
    std::vector<Solved> solved;
    for (const std::vector<double>& row : rows) solved.push_back(targets.solve(row, is_pose));
    return solved;
  };
  auto solved = co_await parts_.compute_thread.ask(job);
  json::array q_deg, residual_mm, residual_deg, iterations, damped;
  for (std::size_t i = 0; i < solved.size(); ++i) {
    if (!solved[i]) {
      const std::string key =
          std::string{"params."} + (is_pose ? "poses" : "joints") + "[" + std::to_string(i) + "]";
      co_return std::unexpected(RpcError{ErrorCode::InvalidParams, key + ": " + solved[i].error(), key});
    }
    q_deg.push_back(record::joints_json(solved[i]->q, nominal));
    residual_mm.emplace_back(solved[i]->residual_mm);
    residual_deg.emplace_back(solved[i]->residual_rad * kDegPerRad);
    iterations.emplace_back(solved[i]->iterations);
    damped.emplace_back(solved[i]->damped);
  }
  co_return json::object{{"joints", std::move(q_deg)},
                         {"residual_mm", std::move(residual_mm)},
                         {"residual_deg", std::move(residual_deg)},
                         {"iterations", std::move(iterations)},
                         {"damped", std::move(damped)}};
}

void DaemonCell::publish_model(const char* change, const ModelRecord& record) {
  log_info("model " + record.id + " " + change);
  parts_.events.publish(control::Topic::Model,
                        json::object{{"change", change}, {"model", model_json(record)}});
}

}  // namespace truepose::daemon
