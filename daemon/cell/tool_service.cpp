#include "daemon/cell/tool_service.hpp"

#include <set>
#include <utility>

#include "config/frame_file.hpp"
#include "daemon/log/log.hpp"
#include "proto/control/json_text.hpp"
#include "proto/record/frame_document.hpp"

namespace truepose::daemon {

namespace asio = boost::asio;
namespace json = boost::json;
using control::ErrorCode;
using control::RpcError;

std::vector<Method<ToolService>> ToolService::methods() {
  return {{"tool.list", &ToolService::list},
          {"tool.activate", &ToolService::activate},
          {"tool.deactivate", &ToolService::deactivate}};
}

const config::ToolFile* ToolService::of(int number) const {
  const auto found = in_use_.find(number);
  return found != in_use_.end() ? &found->second.file : config::tool_of(parts_.config, number);
}

std::string ToolService::campaign_of(int number) const {
  const auto found = in_use_.find(number);
  return found != in_use_.end() ? found->second.campaign_id : "";
}

/// @param serial  empty: of a record that does not tell it
std::string ToolService::other_arm(const std::string& what, const std::string& serial) const {
  return serial.empty() ? "" : devices_.other_arm(what, serial);
}

std::string ToolService::other_arm(int number) const {
  const auto found = in_use_.find(number);
  if (found == in_use_.end()) return {};
  return other_arm("tool " + std::to_string(number), found->second.robot_serial);
}

std::string ToolService::other_arm() const {
  for (const auto& [number, tool] : in_use_)
    if (std::string other = other_arm(number); !other.empty()) return other;
  return {};
}

std::expected<ToolService::InUse, std::string> ToolService::usable(const ToolInUse& stored) const {
  const auto document = control::parse_json(stored.document);
  if (!document) return std::unexpected("its document: " + document.error());
  const auto frame = record::read_frame_document(*document);
  if (!frame) return std::unexpected("its document: " + frame.error());
  if (frame->yaml.empty()) return std::unexpected(record::why_not_usable(*frame));
  try {
    return InUse{stored.campaign_id, stored.measured, stored.robot_serial,
                 config::parse_tool(frame->yaml, "its tool", parts_.config.robot.model)};
  } catch (const config::ConfigError& error) {
    return std::unexpected(std::string{error.what()});
  }
}

asio::awaitable<StoreResult<void>> ToolService::load() {
  auto job = [this] { return parts_.store.tools_in_use(); };
  auto stored = co_await parts_.store_thread.ask(job);
  if (!stored) co_return std::unexpected(stored.error());
  in_use_.clear();
  for (const ToolInUse& each : *stored) {
    auto tool = usable(each);
    if (tool) in_use_.emplace(each.number, *std::move(tool));
    if (!tool)
      log_error("tool " + std::to_string(each.number) + " of campaign " + each.campaign_id + ": " +
                tool.error());
  }
  co_return StoreResult<void>{};
}

json::object ToolService::json(int number) const {
  const auto found = in_use_.find(number);
  const bool measured = found != in_use_.end();
  return {{"number", number},
          {"krl", record::tool_statement(number, of(number)->X_told)},
          {"campaign_id", measured ? json::value(found->second.campaign_id) : json::value{}},
          {"measured", measured ? json::value(found->second.measured) : json::value{}}};
}

MethodReply ToolService::list(json::object params) {
  if (auto wrong = no_parameters(params)) co_return std::unexpected(*wrong);
  std::set<int> numbers;
  for (const config::ToolFile& tool : parts_.config.tools) numbers.insert(tool.number);
  for (const auto& [number, tool] : in_use_) numbers.insert(number);
  json::array tools;
  for (const int number : numbers) tools.push_back(json(number));
  co_return json::object{{"tools", std::move(tools)}};
}

std::string ToolService::why_not(const CampaignRecord& record) const {
  if (record.kind != "tool" || record.state != "done")
    return "campaign " + record.id + " measured no tool, or is not done";
  return other_arm("the tool", record.robot_serial);
}

MethodReply ToolService::activate(json::object params, std::string) {
  control::ParamReader read{params};
  const std::string id = read.required(read.id("id"), "id");
  if (auto wrong = read.finish()) co_return std::unexpected(*wrong);
  auto find = [this, id] { return parts_.store.campaign(id); };
  auto record = co_await parts_.store_thread.ask(find);
  if (!record) co_return std::unexpected(store_unusable(record.error()));
  if (!*record) co_return std::unexpected(RpcError{ErrorCode::NotFound, "no such campaign"});
  if (const std::string why = why_not(**record); !why.empty())
    co_return std::unexpected(runner_.wrong_state(why));
  auto tool = usable({0, id, (*record)->ended, (*record)->robot_serial, (*record)->document});
  if (!tool) co_return std::unexpected(runner_.wrong_state("campaign " + id + ": " + tool.error()));
  const int number = tool->file.number;
  auto use = [this, number, id] { return parts_.store.use_tool(number, id); };
  auto used = co_await parts_.store_thread.ask(use);
  if (!used) co_return std::unexpected(store_unusable(used.error()));
  in_use_.insert_or_assign(number, *std::move(tool));
  log_info("tool " + std::to_string(number) + " is the one that campaign " + id + " measured");
  changed_();
  co_return json(number);
}

MethodReply ToolService::deactivate(json::object params, std::string) {
  control::ParamReader read{params};
  const auto number = static_cast<int>(read.required(read.integer("number", 1, 1000), "number"));
  if (auto wrong = read.finish()) co_return std::unexpected(*wrong);
  if (!in_use_.contains(number))
    co_return std::unexpected(RpcError{ErrorCode::NotFound, "no tool of this number was taken into use"});
  auto use = [this, number] { return parts_.store.use_tool(number, ""); };
  auto used = co_await parts_.store_thread.ask(use);
  if (!used) co_return std::unexpected(store_unusable(used.error()));
  const std::string was = in_use_.extract(number).mapped().campaign_id;
  log_info("tool " + std::to_string(number) + " is no longer the one that campaign " + was + " measured");
  changed_();
  co_return json::object{{"deactivated", was}};
}

}  // namespace truepose::daemon
