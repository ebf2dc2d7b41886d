#include "daemon/cell/campaign_request.hpp"

#include <algorithm>
#include <utility>

#include "config/cell_setup.hpp"
#include "daemon/campaign/tool_cell.hpp"
#include "daemon/cell/frame_order.hpp"
#include "daemon/cell/target_service.hpp"

namespace truepose::daemon {

AskedCampaign CampaignRequests::start(const rpc::CampaignStart& asked) const {
  AskedCampaign campaign = of_kind(asked);
  if (campaign) campaign->note = asked.note;
  return campaign;
}

AskedCampaign CampaignRequests::of_kind(const rpc::CampaignStart& asked) const {
  if (asked.kind == "targets") return targets(asked);
  if (asked.kind == "iso9283") return iso9283(asked);
  if (asked.kind == "tool") return tool(asked);
  if (asked.kind == "base") return base(asked);
  return calibration(asked);
}

AskedCampaign CampaignRequests::drift_check(const rpc::DriftCheck& asked) const {
  config::CellConfig config = config_for(asked);
  config.campaign.drift_poses = asked.poses.value_or(config.campaign.drift_poses);
  const auto model = models_.needed_for_drift();
  if (!model) return std::unexpected(model.error());
  return CampaignRequest{std::move(config),
                         DriftOrder{*(*model)->drift_reference, asked.update, (*model)->record},
                         asked.activate, asked.note};
}

AskedCampaign CampaignRequests::calibration(const rpc::CampaignStart& asked) const {
  config::CellConfig config = config_for(asked);
  config::CampaignConfig& plan = config.campaign;
  plan.identify_poses = asked.identify_poses.value_or(plan.identify_poses);
  plan.validate_poses = asked.validate_poses.value_or(plan.validate_poses);
  // Of fewer poses all come before the first fit.
  plan.coarse_after = std::min(plan.coarse_after, plan.identify_poses);
  plan.remeasure = asked.remeasure.value_or(plan.remeasure);
  if (const auto why = config::too_few_poses(config)) return rpc::refused("identify_poses", *why);
  return CampaignRequest{std::move(config), CalibrationOrder{}, asked.activate};
}

AskedCampaign CampaignRequests::targets(const rpc::CampaignStart& asked) const {
  config::CellConfig config = config_for(asked);
  const RobotModel& nominal = config.robot.model;
  int& drawn = config.campaign.validate_poses;
  drawn = asked.validate_poses.value_or(std::clamp(drawn, 1, rpc::kMostTargets));
  auto joints = joints_given(asked.joints, nominal);
  if (!joints) return std::unexpected(joints.error());
  const auto model = models_.needed();
  if (!model) return std::unexpected(model.error());
  if (!asked.poses.empty()) joints = joints_at(asked.poses, nominal);
  if (!joints) return std::unexpected(joints.error());
  TargetsOrder order{.cell = (*model)->cell,
                     .model_id = (*model)->record.id,
                     .model_serial = (*model)->record.robot_serial,
                     .targets = *std::move(joints),
                     .loop = {.rounds = *asked.rounds, .tolerance_mm = *asked.tolerance_mm}};
  order.readings = asked.readings.value_or(order.readings);
  return CampaignRequest{std::move(config), std::move(order)};
}

AskedCampaign CampaignRequests::iso9283(const rpc::CampaignStart& asked) const {
  config::CellConfig config = config_for(asked);
  Iso9283Order order{.compensate = asked.compensate,
                     .cycles = asked.cycles.value_or(config.iso9283.cycles),
                     .variation = asked.variation.value_or(config.iso9283.variation)};
  const auto model = models_.needed();
  if (order.compensate && !model) return std::unexpected(model.error());
  if (model) {
    order.cell = (*model)->cell;
    order.model_serial = (*model)->record.robot_serial;
  }
  return CampaignRequest{std::move(config), std::move(order)};
}

AskedCampaign CampaignRequests::tool(const rpc::CampaignStart& asked) const {
  config::CellConfig config = config_for(asked);
  auto order = tool_order(asked, config, models_.tools());
  if (!order) return std::unexpected(order.error());
  const auto model = models_.needed_for_drift();
  if (!model) return std::unexpected(model.error());
  const DriftReference& reference = *(*model)->drift_reference;
  order->by = {reference.cell, reference.covariance, reference.noise};
  order->model_id = (*model)->record.id;
  order->model_serial = (*model)->record.robot_serial;
  config = cell_with_tool(std::move(config), *order);
  return CampaignRequest{std::move(config), *std::move(order)};
}

AskedCampaign CampaignRequests::base(const rpc::CampaignStart& asked) const {
  auto order = base_order(asked, models_.tools());
  if (!order) return std::unexpected(order.error());
  const auto model = models_.needed_for_drift();
  if (!model) return std::unexpected(model.error());
  const DriftReference& reference = *(*model)->drift_reference;
  const auto usable =
      use_model({reference.cell, reference.covariance, reference.noise}, (*model)->record, *order);
  if (!usable) return std::unexpected(runner_.wrong_state(usable.error()));
  return CampaignRequest{config_, *std::move(order)};
}

}  // namespace truepose::daemon
