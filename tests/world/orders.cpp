#include "tests/world/orders.hpp"

#include <boost/json/serialize.hpp>
#include <utility>

#include "tests/world/answers.hpp"

namespace truepose::world {

namespace asio = boost::asio;
namespace json = boost::json;

asio::awaitable<json::value> Orders::give(std::string method, json::object params) {
  params["command_id"] = client_.name() + '-' + std::to_string(++given_);
  json::value answer = co_await send(std::move(method), std::move(params));
  co_return answer;
}

asio::awaitable<void> Orders::repeat_lost() {
  if (!lost_) co_return;
  json::object params = lost_->params;
  co_await send(lost_->method, std::move(params));
}

asio::awaitable<json::value> Orders::send(std::string method, json::object params) {
  log_.trace("order", client_.name() + ": " + method + " " + json::serialize(params));
  json::value answer = co_await client_.ask(method, params);
  lost_.reset();
  if (answer.is_null()) lost_ = Request{.method = method, .params = std::move(params)};
  if (answer.is_object() && answer.as_object().contains("error")) {
    const std::string reason = text_at(answer.as_object().at("error").as_object(), "message");
    log_.trace("refused", reason);
    if (reason.empty()) log_.broken(method + " is refused without a reason");
  }
  co_return answer;
}

}  // namespace truepose::world
