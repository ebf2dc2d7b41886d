#include "daemon/cell/campaign_request.hpp"

#include <algorithm>
#include <limits>
#include <utility>

#include "config/cell_setup.hpp"
#include "core/arm/joint_units.hpp"
#include "daemon/campaign/tool_cell.hpp"
#include "daemon/cell/frame_order.hpp"
#include "daemon/cell/target_service.hpp"

namespace truepose::daemon {

namespace json = boost::json;
using control::ParamReader;

namespace {

// The document of so many fits into one line of the protocol.
constexpr std::size_t kMostTargets = 100;
constexpr std::size_t kLongestNote = 500;

void read_seed(ParamReader& read, config::CampaignConfig& campaign) {
  const auto seed = read.integer("seed", 0, std::numeric_limits<std::int64_t>::max());
  if (seed) campaign.seed = static_cast<std::uint64_t>(*seed);
}

void read_count(ParamReader& read, const char* key, int least, int most, int& count) {
  count = static_cast<int>(read.integer(key, least, most).value_or(count));
}

}  // namespace

AskedCampaign CampaignRequests::start(const json::object& params) const {
  ParamReader read{params};
  const std::string kind = read.text("kind").value_or("calibration");
  std::string note = read.text("note", kLongestNote).value_or("");
  AskedCampaign asked = of_kind(kind, read);
  if (asked) asked->note = std::move(note);
  return asked;
}

AskedCampaign CampaignRequests::of_kind(std::string_view kind, ParamReader& read) const {
  if (kind == "calibration") return calibration(read);
  if (kind == "targets") return targets(read);
  if (kind == "iso9283") return iso9283(read);
  if (kind == "tool") return tool(read);
  if (kind == "base") return base(read);
  read.fail("kind", "expected calibration, targets, iso9283, tool or base");
  return std::unexpected(*read.finish());
}

AskedCampaign CampaignRequests::drift_check(const json::object& params) const {
  ParamReader read{params};
  config::CellConfig config = config_;
  read_count(read, "poses", 1, 1000, config.campaign.drift_poses);
  read_seed(read, config.campaign);
  const bool update = read.boolean("update").value_or(false);
  const bool activate = read.boolean("activate").value_or(false);
  std::string note = read.text("note", kLongestNote).value_or("");
  if (activate && !update)
    read.fail("activate", "only a model that was updated can be activated: give update too");
  if (auto wrong = read.finish()) return std::unexpected(*wrong);
  const auto model = models_.needed_for_drift();
  if (!model) return std::unexpected(model.error());
  return CampaignRequest{std::move(config), DriftOrder{*(*model)->drift_reference, update, (*model)->record},
                         activate, std::move(note)};
}

AskedCampaign CampaignRequests::calibration(ParamReader& read) const {
  config::CellConfig config = config_;
  config::CampaignConfig& plan = config.campaign;
  read_count(read, "identify_poses", 5, 1000, plan.identify_poses);
  read_count(read, "validate_poses", 0, 1000, plan.validate_poses);
  // Of fewer poses all come before the first fit.
  plan.coarse_after = std::min(plan.coarse_after, plan.identify_poses);
  read_seed(read, plan);
  plan.remeasure = read.boolean("remeasure").value_or(plan.remeasure);
  const bool activate = read.boolean("activate").value_or(true);
  if (const auto why = config::too_few_poses(config)) read.fail("identify_poses", *why);
  if (auto wrong = read.finish()) return std::unexpected(*wrong);
  return CampaignRequest{std::move(config), CalibrationOrder{}, activate};
}

AskedCampaign CampaignRequests::targets(ParamReader& read) const {
  config::CellConfig config = config_;
  const RobotModel& nominal = config.robot.model;
  const auto joints = read.rows("joints", static_cast<std::size_t>(nominal.joint_count()), kMostTargets);
  const auto poses = read.rows("poses", 6, kMostTargets);
  if (joints && poses) read.fail("joints", "give joints or poses, not both");
  int& drawn = config.campaign.validate_poses;
  drawn = std::clamp<int>(drawn, 1, kMostTargets);
  read_count(read, "validate_poses", 1, kMostTargets, drawn);
  TargetsOrder order;
  read_count(read, "rounds", 1, 20, order.loop.rounds);
  order.loop.tolerance_mm = read.number("tolerance_mm", 0, 10).value_or(order.loop.tolerance_mm);
  read_count(read, "readings", 1, 100, order.readings);
  read_seed(read, config.campaign);
  if (auto wrong = read.finish()) return std::unexpected(*wrong);
  const auto model = models_.needed();
  if (!model) return std::unexpected(model.error());
  order.cell = (*model)->cell;
  order.model_id = (*model)->record.id;
  for (const auto& row : joints.value_or(std::vector<std::vector<double>>{}))
    order.targets.push_back(joints_from(row, nominal));
  if (poses) {
    auto reached = joints_at(*poses, nominal);
    if (!reached) return std::unexpected(reached.error());
    order.targets = *std::move(reached);
  }
  return CampaignRequest{std::move(config), std::move(order)};
}

AskedCampaign CampaignRequests::iso9283(ParamReader& read) const {
  config::CellConfig config = config_;
  Iso9283Order order{.cycles = config.iso9283.cycles};
  read_count(read, "cycles", 2, 1000, order.cycles);
  order.variation = read.boolean("variation").value_or(config.iso9283.variation);
  order.compensate = read.boolean("compensate").value_or(true);
  read_seed(read, config.campaign);
  if (auto wrong = read.finish()) return std::unexpected(*wrong);
  const auto model = models_.needed();
  if (order.compensate && !model) return std::unexpected(model.error());
  if (model) order.cell = (*model)->cell;
  return CampaignRequest{std::move(config), std::move(order)};
}

AskedCampaign CampaignRequests::tool(ParamReader& read) const {
  config::CellConfig config = config_;
  auto order = tool_order(read, config, models_.tools());
  read_seed(read, config.campaign);
  if (auto wrong = read.finish()) return std::unexpected(*wrong);
  const auto model = models_.needed_for_drift();
  if (!model) return std::unexpected(model.error());
  const DriftReference& reference = *(*model)->drift_reference;
  order.by = {reference.cell, reference.covariance, reference.noise};
  order.model_id = (*model)->record.id;
  config = cell_with_tool(std::move(config), order);
  return CampaignRequest{std::move(config), std::move(order)};
}

AskedCampaign CampaignRequests::base(ParamReader& read) const {
  BaseOrder order = base_order(read, models_.tools());
  if (auto wrong = read.finish()) return std::unexpected(*wrong);
  const auto model = models_.needed_for_drift();
  if (!model) return std::unexpected(model.error());
  const DriftReference& reference = *(*model)->drift_reference;
  const auto usable =
      use_model({reference.cell, reference.covariance, reference.noise}, (*model)->record, order);
  if (!usable) return std::unexpected(runner_.wrong_state(usable.error()));
  return CampaignRequest{config_, std::move(order)};
}

}  // namespace truepose::daemon
