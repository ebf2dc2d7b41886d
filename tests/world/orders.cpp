#include "tests/world/orders.hpp"

#include <boost/json/serialize.hpp>
#include <utility>

#include "tests/world/answers.hpp"

namespace truepose::world {

namespace asio = boost::asio;
namespace json = boost::json;

asio::awaitable<json::value> Orders::give(std::string method, json::object params) {
  log_.trace("order", client_.name() + ": " + method + " " + json::serialize(params));
  const json::value answer = co_await client_.ask(method, std::move(params));
  is_last_lost_ = answer.is_null();
  if (answer.is_object() && answer.as_object().contains("error")) {
    const std::string reason = text_at(answer.as_object().at("error").as_object(), "message");
    log_.trace("refused", reason);
    if (reason.empty()) log_.broken(method + " is refused without a reason");
  }
  co_return answer;
}

}  // namespace truepose::world
