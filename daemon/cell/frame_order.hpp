#pragma once

#include <expected>
#include <string>

#include "daemon/campaign/campaign_result.hpp"
#include "daemon/cell/tool_service.hpp"
#include "proto/rpc/campaign.hpp"

namespace truepose::daemon {

/// What campaign.start asks for of a tool, without the model to measure it by. Where the request does not say
/// where a point is, it is looked for about where the cell has the tool's TCP: as it was measured before,
/// else where the stream keeps the position, else where the cell's reflector is. Error: what is wrong with a
/// parameter.
std::expected<ToolOrder, control::RpcError> tool_order(const rpc::CampaignStart& asked,
                                                       const config::CellConfig& config,
                                                       const ToolService& tools);

/// The same of a work frame, with the tool that touches its points where one does.
std::expected<BaseOrder, control::RpcError> base_order(const rpc::CampaignStart& asked,
                                                       const ToolService& tools);

/// Has a work frame measured by a model, which also says where the tool is that touches its points. Error:
/// why the tool is of no use under that, one sentence.
std::expected<void, std::string> use_model(MeasuringCell by, const ModelRecord& model, BaseOrder& order);

}  // namespace truepose::daemon
