#include <algorithm>
#include <boost/asio/co_spawn.hpp>
#include <boost/json/array.hpp>
#include <boost/uuid/random_generator.hpp>
#include <boost/uuid/uuid_io.hpp>
#include <limits>

#include "config/cell_setup.hpp"
#include "core/arm/joint_units.hpp"
#include "core/compensate/nominal_inverse.hpp"
#include "core/math/angles.hpp"
#include "daemon/cell/campaign_run.hpp"
#include "proto/control/param_reader.hpp"

// campaign.start and drift.check.

namespace truepose::daemon {

namespace asio = boost::asio;
namespace json = boost::json;
using control::ErrorCode;
using control::ParamReader;
using control::RpcError;

namespace {

// The document of so many fits into one line of the protocol.
constexpr std::size_t kMostTargets = 100;

std::string new_uuid() { return boost::uuids::to_string(boost::uuids::random_generator{}()); }

void read_seed(ParamReader& read, config::CampaignConfig& campaign) {
  const auto seed = read.integer("seed", 0, std::numeric_limits<std::int64_t>::max());
  if (seed) campaign.seed = static_cast<std::uint64_t>(*seed);
}

/// The joints of the nominal arm at poses of the flange (mm, KUKA's angles in deg); an error names the row.
std::expected<std::vector<JointVector>, RpcError> joints_at(const std::vector<std::vector<double>>& poses,
                                                            const RobotModel& nominal) {
  NominalInverse inverse(nominal, std::nullopt);
  std::vector<JointVector> joints;
  for (const std::vector<double>& row : poses) {
    const auto q = inverse.at_pose(pose_from_kuka({row[0], row[1], row[2]}, {row[3], row[4], row[5]}));
    if (!q) {
      const std::string key = "params.poses[" + std::to_string(joints.size()) + "]";
      return std::unexpected(RpcError{ErrorCode::InvalidParams, key + ": cannot be reached", key});
    }
    joints.push_back(*q);
  }
  return joints;
}

}  // namespace

DaemonCell::Reply DaemonCell::campaign_start(json::object params) {
  ParamReader read{params};
  const std::string kind = read.text("kind").value_or("calibration");
  params.erase("kind");
  Result started;
  if (kind == "calibration") {
    started = co_await start_calibration(params);
  } else if (kind == "targets") {
    started = co_await start_targets(params);
  } else if (kind == "iso9283") {
    started = co_await start_iso9283(params);
  } else {
    read.fail("kind", "expected calibration, targets or iso9283");
    started = std::unexpected(*read.finish());
  }
  co_return started;
}

DaemonCell::Reply DaemonCell::start_calibration(json::object params) {
  ParamReader read{params};
  config::CellConfig config = parts_.config;
  config::CampaignConfig& plan = config.campaign;
  plan.identify_poses =
      static_cast<int>(read.integer("identify_poses", 5, 1000).value_or(plan.identify_poses));
  plan.validate_poses =
      static_cast<int>(read.integer("validate_poses", 0, 1000).value_or(plan.validate_poses));
  read_seed(read, plan);
  plan.remeasure = read.boolean("remeasure").value_or(plan.remeasure);
  const bool activate = read.boolean("activate").value_or(true);
  if (const auto why = config::too_few_poses(config)) read.fail("identify_poses", *why);
  if (auto wrong = read.finish()) co_return std::unexpected(*wrong);
  co_return start_campaign(config, CalibrationOrder{}, activate);
}

DaemonCell::Reply DaemonCell::start_targets(json::object params) {
  ParamReader read{params};
  config::CellConfig config = parts_.config;
  const RobotModel& nominal = config.robot.model;
  const auto joints = read.rows("joints", static_cast<std::size_t>(nominal.joint_count()), kMostTargets);
  const auto poses = read.rows("poses", 6, kMostTargets);
  if (joints && poses) read.fail("joints", "give joints or poses, not both");
  config.campaign.validate_poses = static_cast<int>(
      read.integer("validate_poses", 1, kMostTargets)
          .value_or(std::clamp<int>(config.campaign.validate_poses, 1, static_cast<int>(kMostTargets))));
  TargetsOrder order;
  order.loop.rounds = static_cast<int>(read.integer("rounds", 1, 20).value_or(order.loop.rounds));
  order.loop.tolerance_mm = read.number("tolerance_mm", 0, 10).value_or(order.loop.tolerance_mm);
  order.readings = static_cast<int>(read.integer("readings", 1, 100).value_or(order.readings));
  read_seed(read, config.campaign);
  if (auto wrong = read.finish()) co_return std::unexpected(*wrong);
  if (const std::string why_not = model_trouble(); !why_not.empty()) co_return needs_model(why_not);
  order.cell = active_->cell;
  for (const auto& row : joints.value_or(std::vector<std::vector<double>>{}))
    order.targets.push_back(joints_from(row, nominal));
  if (poses) {
    auto reached = joints_at(*poses, nominal);
    if (!reached) co_return std::unexpected(reached.error());
    order.targets = *std::move(reached);
  }
  co_return start_campaign(config, std::move(order));
}

DaemonCell::Reply DaemonCell::start_iso9283(json::object params) {
  ParamReader read{params};
  config::CellConfig config = parts_.config;
  Iso9283Order order;
  order.cycles = static_cast<int>(read.integer("cycles", 2, 1000).value_or(config.iso9283.cycles));
  order.variation = read.boolean("variation").value_or(config.iso9283.variation);
  order.compensate = read.boolean("compensate").value_or(true);
  read_seed(read, config.campaign);
  if (auto wrong = read.finish()) co_return std::unexpected(*wrong);
  const std::string why_not = model_trouble();
  if (order.compensate && !why_not.empty()) co_return needs_model(why_not);
  if (why_not.empty()) order.cell = active_->cell;
  co_return start_campaign(config, std::move(order));
}

DaemonCell::Reply DaemonCell::drift_check(json::object params) {
  ParamReader read{params};
  config::CellConfig config = parts_.config;
  config::CampaignConfig& plan = config.campaign;
  plan.drift_poses = static_cast<int>(read.integer("poses", 1, 1000).value_or(plan.drift_poses));
  read_seed(read, plan);
  if (auto wrong = read.finish()) co_return std::unexpected(*wrong);
  std::string why_not = model_trouble();
  if (why_not.empty() && !active_->drift_reference)
    why_not = "the active model holds no noise and was not validated";
  if (!why_not.empty()) co_return needs_model(why_not);
  co_return start_campaign(config, *active_->drift_reference);
}

std::string DaemonCell::model_trouble() const {
  if (!active_) return model_fault_ ? model_fault_->text : "no model is active";
  if (!identities_ || identities_->robot.serial == active_->record.robot_serial) return {};
  return "the active model belongs to arm " + active_->record.robot_serial + ", not to " +
         identities_->robot.serial;
}

DaemonCell::Result DaemonCell::needs_model(const std::string& why_not) const {
  return std::unexpected(RpcError{ErrorCode::WrongState,
                                  why_not + "; allowed: model.activate, campaign.start",
                                  {},
                                  std::string{state()},
                                  {"model.activate", "campaign.start"}});
}

DaemonCell::Result DaemonCell::start_campaign(const config::CellConfig& config, CampaignOrder order,
                                              bool activate) {
  const std::string id = new_uuid();
  if (auto refused = apply(CampaignStartRequested{id}, "asked for by an operator"))
    return std::unexpected(*refused);
  RunCompute compute = [this](std::function<void()> job) {
    return parts_.compute_thread.run(std::move(job));
  };
  // The kinds are in the order of the orders.
  StoreJournal::Options options{.campaign_id = id,
                                .model_id = new_uuid(),
                                .config = config,
                                .kind = static_cast<CampaignKind>(order.index()),
                                .activate = activate};
  CampaignObserver& observer = *this;
  campaign_ = std::make_unique<CampaignRun>(std::move(options), config, parts_, observer, std::move(compute),
                                            std::move(order));
  asio::co_spawn(parts_.io, run_campaign(), [](std::exception_ptr failed) {
    if (failed) std::rethrow_exception(failed);
  });
  return json::object{{"id", id}, {"total", campaign_->campaign.progress().total}};
}

}  // namespace truepose::daemon
