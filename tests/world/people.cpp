#include "tests/world/people.hpp"

#include <gtest/gtest.h>

#include <boost/json/serialize.hpp>
#include <chrono>
#include <utility>

namespace truepose::world {

namespace asio = boost::asio;
namespace json = boost::json;
using namespace std::chrono_literals;

asio::awaitable<json::object> asked(Cell& cell, std::string method, json::object params) {
  const json::value answer = co_await cell.panel.ask(method, std::move(params));
  if (answer.is_object() && answer.as_object().contains("result"))
    co_return answer.as_object().at("result").as_object();
  ADD_FAILURE() << method << ": " << json::serialize(answer);
  co_return json::object{};
}

asio::awaitable<void> connect(Cell& cell) {
  for (int attempt = 0; attempt < 60; ++attempt) {
    const bool open = co_await cell.panel.connect();
    if (open) co_return;
    co_await cell.world.pass(1s);
  }
  ADD_FAILURE() << "the control port takes no client";
}

asio::awaitable<void> campaign_over(Cell& cell) {
  for (;;) {
    const json::object now = co_await asked(cell, "cell.status");
    if (now.empty() || now.at("campaign").is_null()) co_return;
    co_await cell.world.pass(5s);
  }
}

asio::awaitable<json::object> start_campaign(Cell& cell) {
  json::object few{{"identify_poses", 12}, {"validate_poses", 6}, {"remeasure", false}};
  return asked(cell, "campaign.start", std::move(few));
}

asio::awaitable<void> calibrate(Cell& cell) {
  co_await start_campaign(cell);
  co_await campaign_over(cell);
}

}  // namespace truepose::world
