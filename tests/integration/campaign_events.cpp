#include "tests/integration/campaign_events.hpp"

#include <boost/json/array.hpp>
#include <utility>

#include "proto/control/json_text.hpp"

namespace truepose {

namespace json = boost::json;

namespace {

bool is_pause(const control::Event& event) {
  return event.topic == "cell" && event.data.at("state") == "paused";
}

}  // namespace

json::value called(tools::RpcClient& client, const std::string& method, const json::object& params) {
  auto result = client.call(method, params);
  if (!result) throw std::runtime_error{result.error().message};
  return *std::move(result);
}

bool is_end_of_campaign(const control::Event& event) {
  if (event.topic != "campaign") return false;
  const json::value& phase = event.data.at("phase");
  return phase == "done" || phase == "failed" || phase == "aborted" || phase == "interrupted";
}

bool is_loss(const control::Event& event) {
  return event.topic == "cell" && event.data.at("state") == event.data.at("from") &&
         !control::json_text(event.data.at("reason")).contains(" answers");
}

std::vector<control::Event> campaign_in_trouble(const LiveCell& cell, const json::object& params,
                                                const std::function<json::object(std::int64_t)>& happens,
                                                const json::object& when_lost) {
  tools::RpcClient client = cell.client();
  called(client, "events.subscribe", {{"topics", json::array{"campaign", "cell", "log"}}});
  called(client, "campaign.start", params);
  std::vector<control::Event> events;
  std::int64_t measured = 0;
  const auto is_measured = [&measured](const control::Event& event) {
    return event.topic == "campaign" && event.data.at("done").as_int64() > measured;
  };
  while (events.empty() || !is_end_of_campaign(events.back())) {
    const auto more = events_until(client, [&](const auto& event) {
      return is_end_of_campaign(event) || is_pause(event) || is_measured(event) || is_loss(event);
    });
    events.insert(events.end(), more.begin(), more.end());
    const control::Event& last = events.back();
    if (is_pause(last)) {
      called(client, "campaign.resume");
    } else if (is_loss(last)) {
      if (!when_lost.empty()) cell.steer(when_lost);
    } else if (is_measured(last)) {
      measured = last.data.at("done").as_int64();
      if (const json::object line = happens(measured); !line.empty()) cell.steer(line);
    }
  }
  return events;
}

}  // namespace truepose
