#pragma once

#include <chrono>
#include <string>
#include <utility>
#include <vector>

#include "tests/daemon/cell_fixture.hpp"

namespace truepose::daemon {

/// Campaigns that are asked for by a client.
struct CampaignServiceTest : CellTest {
  CampaignServiceTest() {
    config.campaign.remeasure = false;
    load();
  }
  Wait campaign(std::string method, boost::json::object params = {}) {
    const Answer started = co_await ask(std::move(method), std::move(params));
    EXPECT_TRUE(started) << started.error().message;
    co_await campaign_ended();
  }
  /// Starts a campaign, and lets so much time pass.
  Wait under_way(drivers::Duration time = std::chrono::minutes{1}) {
    const Answer started = co_await ask("campaign.start");
    EXPECT_TRUE(started) << started.error().message;
    co_await pass(time);
  }
  /// Runs a whole campaign. @return what campaign.get then says of it
  boost::json::value ended(std::string method, boost::json::object params = {}) {
    play([&]() -> Wait { co_await campaign(std::move(method), std::move(params)); });
    return call("campaign.get", {{"points_limit", 100}}).value();
  }
  std::vector<std::string> phases() {
    std::vector<std::string> names;
    for (const boost::json::value& progress : event_data(control::Topic::Campaign)) {
      const std::string phase = string_at(progress, "/phase");
      if (names.empty() || names.back() != phase) names.push_back(phase);
    }
    return names;
  }
  static std::string string_at(const boost::json::value& value, const char* pointer) {
    return std::string{value.at_pointer(pointer).as_string()};
  }
};

}  // namespace truepose::daemon
