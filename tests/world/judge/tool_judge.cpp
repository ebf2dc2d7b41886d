#include "tests/world/judge/tool_judge.hpp"

#include <boost/json/array.hpp>
#include <boost/json/serialize.hpp>

#include "tests/world/answers.hpp"

namespace truepose::world {

namespace asio = boost::asio;
namespace json = boost::json;

namespace {

std::map<int, std::string> tools_of(const json::object& list) {
  std::map<int, std::string> campaigns;
  for (const json::value& each : list.at("tools").as_array()) {
    const json::object& tool = each.as_object();
    const std::string campaign = text_at(tool, "campaign_id");
    if (!campaign.empty()) campaigns[tool.at("number").to_number<int>()] = campaign;
  }
  return campaigns;
}

}  // namespace

void ToolJudge::answered(const Request& request) {
  const bool activates = request.method == "tool.activate";
  if (!activates && request.method != "tool.deactivate") return;
  if (request.answer.is_null()) campaigns_.reset();
  if (!campaigns_ || !is_result(request.answer)) return;
  if (activates) {
    const json::object& tool = result_of(request.answer);
    (*campaigns_)[tool.at("number").to_number<int>()] = text_at(tool, "campaign_id");
  } else {
    campaigns_->erase(request.params.at("number").to_number<int>());
  }
}

asio::awaitable<void> ToolJudge::look(Client& client) {
  const json::value answer = co_await client.ask("tool.list");
  if (!is_result(answer)) co_return;
  const std::map<int, std::string> in_use = tools_of(result_of(answer));
  if (campaigns_ && in_use != *campaigns_)
    log_.broken("the tools in use are not those that were activated: " + json::serialize(answer));
  campaigns_ = in_use;
}

}  // namespace truepose::world
