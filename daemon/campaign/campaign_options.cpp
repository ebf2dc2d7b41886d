#include "daemon/campaign/campaign_options.hpp"

#include "proto/control/json_text.hpp"
#include "proto/record/forms.hpp"
#include "proto/record/json_io.hpp"

namespace truepose::daemon {

void layout(record::Io& io, ToolPoint& x) {
  io("name", x.point.name);
  io.optional("p", x.point.p_mm, record::kPoint);
  io("at", x.p_F_mm, record::kPoint);
}

void layout(record::Io& io, ToolOrder& x) {
  io("number", x.number, record::kNumber);
  io("points", x.points);
  io("together", x.together);
  io.optional("facing", x.facing_F, record::Xyz{});
  io.optional("orientation", x.R_given, record::KukaAngles{});
  io("poses", x.poses, record::kNumber);
  io.optional("reach", x.reach_F_mm, record::kPoint);
}

void layout(record::Io& io, FixturePoint& x) {
  io("name", x.point.name);
  io.optional("p", x.point.p_mm, record::kPoint);
}

void layout(record::Io& io, BaseOrder& x) {
  io("number", x.number, record::kNumber);
  io("points", x.points);
  io("readings", x.readings, record::kNumber);
}

void layout(record::Io& io, KeptOrder& x) {
  io("options", x.options);
  io("nests", x.nests, record::kCount);
  io("activate", x.activate);
  io("model_id", x.model_id);
  io("targets", x.targets);
  io("rounds", x.loop.rounds, record::kNumber);
  io("tolerance_mm", x.loop.tolerance_mm, record::kNotNegative);
  io("readings", x.readings, record::kNumber);
  io.optional("tool", x.tool);
  io.optional("base", x.base);
  io.optional("touching_tool", x.touching_tool);
}

// What is touched stays where it is, whoever waits for the hand; whoever reads a fixture by the tracker has
// to have it all from one stand.
std::string_view reason_not_resumable(const CampaignOrder& order) {
  const auto* base = std::get_if<BaseOrder>(&order);
  return base && base->touch ? std::string_view{} : reason_not_resumable(kind_name(order));
}

std::string order_text(const CampaignOrder& order, const config::CellConfig& config, bool activate) {
  if (!reason_not_resumable(order).empty()) return {};
  KeptOrder kept{
      .options = config::campaign_options(config),
      .nests = static_cast<int>(config.tracker.nests_mm.size()),
      .activate = activate,
  };
  if (const auto* targets = std::get_if<TargetsOrder>(&order)) {
    kept.model_id = targets->model_id;
    kept.targets = targets->targets;
    kept.loop = targets->loop;
    kept.readings = targets->readings;
  }
  if (const auto* tool = std::get_if<ToolOrder>(&order)) {
    kept.model_id = tool->model_id;
    kept.tool = *tool;
  }
  if (const auto* base = std::get_if<BaseOrder>(&order)) {
    kept.model_id = base->model_id;
    kept.base = *base;
    kept.touching_tool = config::tool_yaml(base->touch->tool);
  }
  return control::json_text(record::to_json(kept));
}

std::expected<KeptOrder, std::string> kept_order(const std::string& text) {
  const auto json = control::parse_json(text);
  if (!json) return std::unexpected(json.error());
  return record::from_json<KeptOrder>(*json);
}

}  // namespace truepose::daemon
