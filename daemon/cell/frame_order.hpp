#pragma once

#include <expected>
#include <string>

#include "daemon/campaign/campaign_result.hpp"
#include "daemon/cell/tool_service.hpp"
#include "proto/control/param_reader.hpp"

namespace truepose::daemon {

/// What campaign.start asks for of a tool, without the model to measure it by. Where the request does not say
/// where a point is, it is looked for about where the cell has the tool's TCP: as it was measured before,
/// else where the stream keeps the position, else where the cell's reflector is. Errors are reported to
/// `read`.
ToolOrder tool_order(control::ParamReader& read, const config::CellConfig& config, const ToolService& tools);

/// The same of a work frame, with the tool that touches its points where one does.
BaseOrder base_order(control::ParamReader& read, const ToolService& tools);

/// Has a work frame measured by a model, which also says where the tool is that touches its points. Error:
/// why the tool is of no use under that, one sentence.
std::expected<void, std::string> use_model(MeasuringCell by, const ModelRecord& model, BaseOrder& order);

}  // namespace truepose::daemon
