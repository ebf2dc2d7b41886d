#include "tests/world/orders.hpp"

#include <boost/json/serialize.hpp>
#include <utility>

#include "tests/world/answers.hpp"

namespace truepose::world {

namespace asio = boost::asio;
namespace json = boost::json;

namespace {

constexpr int kRepeated = 7;  // each order of so many is given twice

}  // namespace

asio::awaitable<json::value> Orders::give(std::string method, json::object params) {
  params["command_id"] = client_.name() + '-' + std::to_string(++given_);
  json::value answer = co_await send(method, params);
  // Control is renewed by each request, and a job has an id of its own.
  const bool repeats = given_ % kRepeated == 0 && !method.starts_with("control.") && !params.contains("job");
  if (!repeats || !is_result(answer)) co_return answer;
  const json::value again = co_await send(method, std::move(params));
  if (!again.is_null() && (!is_result(again) || result_of(again) != result_of(answer)))
    log_.broken(method + " is answered otherwise where it is repeated: " + json::serialize(again));
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
