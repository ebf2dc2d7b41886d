#include <algorithm>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "tests/daemon/watched_stream.hpp"

namespace truepose::daemon {
namespace {

namespace asio = boost::asio;
namespace json = boost::json;
using namespace std::chrono_literals;

const std::vector<std::string> kAsked{"cell.connect",   "cell.disconnect", "cell.acknowledge",
                                      "campaign.start", "campaign.pause",  "campaign.resume",
                                      "campaign.abort", "drift.check",     "stream.start",
                                      "stream.stop",    "stream.arm",      "stream.disarm"};

/// What a cell may be asked for in a state.
struct Allowed {
  std::string state;
  std::vector<std::string> methods;
};
const std::vector<Allowed> kAllowed{
    {"disconnected", {"cell.connect", "campaign.start", "drift.check", "stream.arm"}},
    {"disconnected without a store", {"cell.acknowledge"}},
    {"connecting", {"cell.disconnect"}},
    {"ready", {"cell.disconnect", "campaign.start", "drift.check", "stream.start", "stream.arm"}},
    {"ready without a store", {"cell.disconnect", "cell.acknowledge"}},
    {"ready without a model", {"cell.disconnect", "campaign.start"}},
    {"campaign", {"campaign.pause", "campaign.abort"}},
    {"paused", {"campaign.resume", "campaign.abort"}},
    {"paused without a store", {"campaign.abort", "cell.acknowledge"}},
    {"aborting", {}},
    {"interrupted",
     {"cell.connect", "campaign.start", "drift.check", "stream.arm", "campaign.resume", "campaign.abort"}},
    {"interrupted and ready",
     {"cell.disconnect", "campaign.start", "drift.check", "stream.start", "stream.arm", "campaign.resume",
      "campaign.abort"}},
    {"stream starting", {"stream.stop"}},
    {"streaming", {"cell.acknowledge", "stream.stop"}},
    {"stream stopping", {"cell.acknowledge"}},
    {"frozen", {"cell.acknowledge"}},
    {"armed", {"cell.acknowledge", "stream.disarm"}},
    {"disarming", {"cell.acknowledge"}},
    {"fault", {"cell.acknowledge"}}};

/// Each state with each method that it allows; with none where it allows none.
std::vector<std::pair<Allowed, std::string>> each_allowed() {
  std::vector<std::pair<Allowed, std::string>> each;
  for (const Allowed& row : kAllowed) {
    if (row.methods.empty()) each.emplace_back(row, "");
    for (const std::string& method : row.methods) each.emplace_back(row, method);
  }
  return each;
}

/// A cell that is brought into each of its states.
struct ACellInEveryState : AWatchedStream, testing::WithParamInterface<std::pair<Allowed, std::string>> {
  ACellInEveryState() { config.campaign.remeasure = false; }

  asio::awaitable<json::value> allowed() {
    const Answer now = co_await ask("cell.status");
    co_return now->at("allowed");
  }
  Wait begin(std::string method) {
    const Answer begun = co_await ask(method);
    EXPECT_TRUE(begun) << begun.error().message;
  }
  /// The method has changed the state, and has not yet been answered.
  Wait under_way(std::string method) {
    const json::value before = co_await allowed();
    answered = false;
    asio::co_spawn(io, ask(method), [this](std::exception_ptr, const Answer&) { answered = true; });
    for (json::value now = before; now == before; now = co_await allowed()) co_await pass(1ms);
  }
  Wait paused() {
    co_await begin("campaign.start");
    co_await pass(1min);
    co_await begin("campaign.pause");
  }
  Wait interrupted() {
    co_await begin("campaign.start");
    while (event_data(control::Topic::Measurement).size() < 3) co_await pass(1s);
    co_await cell.shut_down();
    co_await pass(10s);
    co_await ask("cell.acknowledge");
  }
  Wait bring(std::string_view state) {
    if (state == "disconnected") co_await begin("cell.disconnect");
    if (state == "disconnected without a store") {
      co_await begin("cell.disconnect");
      cell.store_failed({"cell.db: full", true});
    }
    if (state == "connecting") {
      co_await begin("cell.disconnect");
      co_await under_way("cell.connect");
    }
    if (state == "ready without a store") cell.store_failed({"cell.db: full", true});
    if (state == "ready without a model") co_await begin("model.deactivate");
    if (state == "campaign") co_await begin("campaign.start");
    if (state == "paused") co_await paused();
    if (state == "paused without a store") {
      co_await paused();
      cell.store_failed({"cell.db: full", true});
    }
    if (state == "aborting") {
      co_await begin("campaign.start");
      co_await pass(1min);
      co_await under_way("campaign.abort");
    }
    if (state == "interrupted" || state == "interrupted and ready") co_await interrupted();
    if (state == "interrupted and ready") co_await begin("cell.connect");
    if (state == "stream starting") {
      sends = false;
      co_await under_way("stream.start");
    }
    if (state == "streaming" || state == "stream stopping" || state == "frozen") co_await streaming();
    if (state == "stream stopping") co_await under_way("stream.stop");
    if (state == "frozen") {
      rig.stuck = rig.q;
      co_await pass(5s);
    }
    if (state == "armed" || state == "disarming") co_await begin("stream.arm");
    if (state == "disarming") {
      co_await pass(2s);
      co_await under_way("stream.disarm");
    }
    if (state == "fault") {
      robot.disconnect();
      co_await pass(2s);
    }
  }
  /// Names the interrupted campaign where there is one.
  asio::awaitable<Answer> try_to(std::string method, const json::value& status) {
    json::object params;
    const bool of_a_campaign = method == "campaign.resume" || method == "campaign.abort";
    if (const auto& left = status.at("interrupted").as_array(); of_a_campaign && !left.empty())
      params["id"] = left[0].at("id");
    Answer answer = co_await ask(method, params);
    co_return answer;
  }
  static bool was_refused(const Answer& answer) {
    return !answer && (answer.error().code == control::ErrorCode::WrongState ||
                       answer.error().code == control::ErrorCode::Store);
  }

  bool answered = true;
};

TEST_P(ACellInEveryState, CarriesOutWhatItAllowsAndRefusesAllElse) {
  const auto& [row, method] = GetParam();
  play([&]() -> Wait {
    co_await bring(row.state);
    const Answer now = co_await ask("cell.status");
    const json::array allowed = now->at("allowed").as_array();
    std::vector<std::string> names;
    for (const json::value& one : allowed) names.emplace_back(one.as_string());
    EXPECT_THAT(names, testing::UnorderedElementsAreArray(row.methods)) << control::json_text(*now);
    for (const std::string& other : kAsked) {
      if (std::ranges::count(names, other) > 0) continue;
      const Answer answer = co_await try_to(other, *now);
      EXPECT_TRUE(was_refused(answer)) << other << " was carried out";
      const Answer after = co_await ask("cell.status");
      EXPECT_EQ(after->at("allowed"), allowed) << other;
    }
    if (!method.empty()) {
      const Answer answer = co_await try_to(method, *now);
      EXPECT_FALSE(was_refused(answer)) << answer.error().message;
    }
    while (!answered) co_await pass(100ms);
    co_await cell.shut_down();
    co_await pass(10s);
  });
}

INSTANTIATE_TEST_SUITE_P(Each, ACellInEveryState, testing::ValuesIn(each_allowed()), [](const auto& name) {
  std::string text = name.param.first.state + " " + name.param.second;
  std::ranges::replace_if(
      text, [](char c) { return c == ' ' || c == '.'; }, '_');
  return text;
});

}  // namespace
}  // namespace truepose::daemon
