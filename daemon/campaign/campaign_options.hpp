#pragma once

#include <expected>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "daemon/campaign/campaign_result.hpp"

namespace truepose::daemon {

/// What a campaign was ordered to do, as the store keeps it so that it may continue after the end of the
/// daemon.
struct KeptOrder {
  std::string options;  ///< as config::campaign_options() says them
  int nests = 0;        ///< that the cell had
  bool activate = false;
  std::string model_id;  ///< of one that works with a model
  // Of a campaign that drives to targets.
  std::vector<JointVector> targets;  ///< rad, mm
  TrackerLoopOptions loop;
  int readings = 1;
  std::optional<ToolOrder> tool;  ///< of one that measures a tool, without its model
  std::optional<BaseOrder> base;  ///< of one that measures a base by touching, without model and tool
  std::string touching_tool;      ///< of that, the tool's file (YAML); else empty
};

/// Why a campaign of this order cannot be resumed after an interruption; empty: it can.
std::string_view reason_not_resumable(const CampaignOrder& order);

/// @return the text; empty for a campaign that cannot be resumed
std::string order_text(const CampaignOrder& order, const config::CellConfig& config, bool activate);

/// Error: what in the text cannot be read.
std::expected<KeptOrder, std::string> kept_order(const std::string& text);

}  // namespace truepose::daemon
