#include "tests/world/point_judge.hpp"

#include <boost/json/serialize.hpp>
#include <utility>

#include "tests/world/answers.hpp"

namespace truepose::world {

namespace asio = boost::asio;
namespace json = boost::json;

void PointJudge::take(const json::object& measurement) {
  if (measurement.at("p_mm").is_null()) return;
  reported_[text_at(measurement, "campaign_id")].insert(json::serialize(measurement.at("p_mm")));
  ++points;
}

asio::awaitable<void> PointJudge::compare_with_store(Client& client) {
  for (const auto& [campaign, points_of_it] : reported_) {
    json::object which{{"id", campaign}, {"limit", 1000}};
    const json::value answer = co_await client.ask("campaign.points", std::move(which));
    if (!is_result(answer)) {
      log_.broken("the points of campaign " + campaign + " are lost: " + json::serialize(answer));
      continue;
    }
    std::set<std::string> stored;
    for (const json::value& point : result_of(answer).at("points").as_array())
      stored.insert(json::serialize(point.as_object().at("p_mm")));
    for (const std::string& point : points_of_it) {
      if (!stored.contains(point))
        log_.broken("campaign " + campaign + ": the reported point " + point + " is lost");
    }
  }
}

}  // namespace truepose::world
