#include "daemon/cell/tool_service.hpp"

#include <utility>

#include "config/frame_file.hpp"
#include "core/planted_bug.hpp"
#include "daemon/log/log.hpp"
#include "proto/control/json_text.hpp"
#include "proto/record/frame_document.hpp"
#include "proto/text/digest.hpp"

namespace truepose::daemon {

namespace asio = boost::asio;
using control::ErrorCode;
using control::RpcError;

std::vector<Served<ToolService>> ToolService::methods() {
  return {&ToolService::list, &ToolService::activate, &ToolService::deactivate};
}

const config::ToolFile* ToolService::of(int number) const {
  const auto found = in_use_.find(number);
  if (found == in_use_.end()) return config::tool_of(parts_.config, number);
  return found->second.file ? &*found->second.file : nullptr;
}

std::string ToolService::campaign_of(int number) const {
  const auto found = in_use_.find(number);
  return found != in_use_.end() ? found->second.campaign_id : "";
}

/// @param serial  empty: of a record that does not tell it
std::string ToolService::other_arm(const std::string& what, const std::string& serial) const {
  return serial.empty() ? "" : devices_.other_arm(what, serial);
}

std::string ToolService::refusal(int number) const {
  const std::string what = "tool " + std::to_string(number);
  const auto found = in_use_.find(number);
  if (found != in_use_.end() && !found->second.file)
    return what + " of campaign " + found->second.campaign_id + " is refused: " + found->second.file.error();
  const config::ToolFile* const file = of(number);
  return file ? other_arm(what, file->serial) : "";
}

std::string ToolService::refusal() const {
  for (const int number : numbers())
    if (std::string why = refusal(number); !why.empty()) return why;
  return {};
}

std::set<int> ToolService::numbers() const {
  std::set<int> numbers;
  for (const config::ToolFile& tool : parts_.config.tools) numbers.insert(tool.number);
  for (const auto& [number, tool] : in_use_) numbers.insert(number);
  return numbers;
}

std::expected<config::ToolFile, std::string> ToolService::measured_by(const CampaignRecord& campaign) const {
  const std::string remedy = "; measure the tool again";
  if (campaign.kind != "tool" || campaign.state != "done")
    return std::unexpected("it measured no tool, or is not done");
  if (campaign.document_sha256 != text::sha256_hex(campaign.document))
    return std::unexpected("its document is not the one that was stored (another SHA-256)" + remedy);
  const auto document = control::parse_json(campaign.document);
  if (!document) return std::unexpected("its document: " + document.error());
  const auto frame = record::read_frame_document(*document);
  if (!frame) return std::unexpected("its document: " + frame.error());
  if (frame->yaml.empty()) return std::unexpected(record::why_not_usable(*frame));
  try {
    config::ToolFile tool = config::parse_tool(frame->yaml, "its tool", parts_.config.robot.model);
    if (frame->number != tool.number || frame->krl != record::tool_statement(tool.number, tool.X_controller))
      return std::unexpected("its document is of another frame than its tool" + remedy);
    if (tool.serial != campaign.robot_serial)
      return std::unexpected("its tool is of arm '" + tool.serial + "', its campaign of arm '" +
                             campaign.robot_serial + "'" + remedy);
    return tool;
  } catch (const config::ConfigError& error) {
    return std::unexpected(std::string{error.what()});
  }
}

asio::awaitable<StoreResult<void>> ToolService::load() {
  struct Stored {
    int number;
    CampaignRecord campaign;
  };
  auto job = [this]() -> StoreResult<std::vector<Stored>> {
    const auto in_use = parts_.store.tools_in_use();
    if (!in_use) return std::unexpected(in_use.error());
    std::vector<Stored> stored;
    for (const ToolInUse& each : *in_use) {
      auto campaign = parts_.store.campaign(each.campaign_id);
      if (!campaign) return std::unexpected(campaign.error());
      stored.push_back({each.number, campaign->value_or(CampaignRecord{.id = each.campaign_id})});
    }
    return stored;
  };
  auto stored = co_await parts_.store_thread.ask(job);
  if (!stored) co_return std::unexpected(stored.error());
  in_use_.clear();
  for (const auto& [number, campaign] : *stored) {
    auto tool = measured_by(campaign);
    if (tool && tool->number != number)
      tool = std::unexpected("its campaign measured tool " + std::to_string(tool->number));
    in_use_.emplace(number, InUse{campaign.id, campaign.ended, std::move(tool)});
    if (const std::string why = refusal(number); !why.empty()) log_error(why);
  }
  co_return StoreResult<void>{};
}

rpc::ToolInUse ToolService::in_use(int number) const {
  const config::ToolFile* const file = of(number);
  rpc::ToolInUse tool{.number = number};
  if (file) tool.krl = record::tool_statement(number, file->X_controller);
  if (const auto measured = in_use_.find(number); measured != in_use_.end()) {
    tool.campaign_id = measured->second.campaign_id;
    tool.measured = measured->second.measured;
  }
  if (const std::string why = refusal(number); !why.empty()) tool.refused = why;
  return tool;
}

Reply<rpc::ToolList> ToolService::list(rpc::ToolList) {
  rpc::ToolList::Result result;
  for (const int number : numbers()) result.tools.push_back(in_use(number));
  co_return result;
}

Reply<rpc::ToolActivate> ToolService::activate(rpc::ToolActivate request) {
  const std::string id = request.id;
  auto find = [this, id] { return parts_.store.campaign(id); };
  auto record = co_await parts_.store_thread.ask(find);
  if (!record) co_return std::unexpected(store_unusable(record.error()));
  if (!*record) co_return std::unexpected(RpcError{ErrorCode::NotFound, "no such campaign"});
  if (const std::string other = other_arm("the tool", (*record)->robot_serial); !other.empty())
    co_return std::unexpected(runner_.wrong_state(other));
  auto tool = measured_by(**record);
  if (!tool) co_return std::unexpected(runner_.wrong_state("campaign " + id + ": " + tool.error()));
  const int number = tool->number;
  auto use = [this, number, id] { return parts_.store.use_tool(number, id); };
  auto used = co_await parts_.store_thread.ask(use);
  if (!used) co_return std::unexpected(store_unusable(used.error()));
  in_use_.insert_or_assign(number, InUse{id, (*record)->ended, *std::move(tool)});
  log_info("tool " + std::to_string(number) + " is the one that campaign " + id + " measured");
  changed_();
  co_return in_use(number);
}

Reply<rpc::ToolDeactivate> ToolService::deactivate(rpc::ToolDeactivate request) {
  const int number = request.number;
  if (!in_use_.contains(number))
    co_return std::unexpected(RpcError{ErrorCode::NotFound, "no tool of this number was taken into use"});
  auto use = [this, number]() -> StoreResult<void> {
    if (planted("a tool taken out of use is back after a restart")) return {};
    return parts_.store.use_tool(number, "");
  };
  auto used = co_await parts_.store_thread.ask(use);
  if (!used) co_return std::unexpected(store_unusable(used.error()));
  const std::string was = in_use_.extract(number).mapped().campaign_id;
  log_info("tool " + std::to_string(number) + " is not the one any more that campaign " + was + " measured");
  changed_();
  co_return rpc::ToolDeactivate::Result{was};
}

}  // namespace truepose::daemon
