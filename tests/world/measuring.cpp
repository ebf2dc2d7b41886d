#include "tests/world/measuring.hpp"

#include <array>
#include <boost/json/array.hpp>
#include <chrono>
#include <stdexcept>
#include <utility>

#include "tests/world/answers.hpp"

namespace truepose::world {

namespace asio = boost::asio;
namespace json = boost::json;
using namespace std::chrono_literals;
using Wait = asio::awaitable<void>;

namespace {

constexpr int kTool = 3, kBase = 5;

}  // namespace

asio::awaitable<bool> Measuring::start_one() {
  const double which = random_.uniform();
  json::object what;
  if (which < 0.3) {
    what = {{"kind", "tool"}, {"number", kTool}, {"poses_per_point", 6}};
  } else if (which < 0.5) {
    what = {{"kind", "iso9283"}, {"cycles", 2}, {"compensate", random_.uniform() < 0.5}};
  } else if (which < 0.7) {
    what = {{"kind", "targets"}, {"validate_poses", 3}, {"rounds", 3}, {"tolerance_mm", 0.05}};
  } else {
    const json::value tools = co_await cell_.panel.ask("tool.list");
    if (!is_result(tools)) co_return false;
    if (!result_of(tools).at("tools").as_array().empty()) {
      const bool touched = co_await touch_base();
      co_return touched;
    }
    what = {{"kind", "tool"}, {"number", kTool}, {"poses_per_point", 6}};
  }
  const bool runs = co_await start(std::move(what));
  co_return runs;
}

asio::awaitable<bool> Measuring::start(json::object what) {
  const json::value begun = co_await orders_.give("campaign.start", std::move(what));
  co_return is_result(begun);
}

/// The arm is jogged to three places, and each is taken as a touch of the tool.
asio::awaitable<bool> Measuring::touch_base() {
  const json::array points{"origin", "x", "xy"};
  json::object what{{"kind", "base"}, {"number", kBase}, {"touch", kTool}, {"points", points}};
  const bool runs = co_await start(std::move(what));
  if (!runs) co_return false;
  constexpr std::array<std::array<double, 2>, 3> kTurns_rad{{{0, 0}, {0.1, 0}, {0, 0.1}}};
  const JointVector from = cell_.devices.axes();
  turn_key(config::ScenarioFault::Mode::T1);
  for (const auto& turn_rad : kTurns_rad) {
    co_await cell_.world.pass(30s);
    JointVector q = from;
    q[0] += turn_rad[0];
    q[2] -= turn_rad[1];
    try {
      cell_.devices.jog(q);
      log_.jogged();
    } catch (const std::invalid_argument&) {
      break;  // the key was turned back meanwhile
    }
    co_await cell_.world.pass(5s);
    co_await orders_.give("campaign.resume");
  }
  turn_key(config::ScenarioFault::Mode::Ext);
  co_return true;
}

void Measuring::turn_key(config::ScenarioFault::Mode mode) {
  config::ScenarioFault act;
  act.kind = config::ScenarioFault::Kind::OperatingMode;
  act.mode = mode;
  cell_.devices.begin(act);
}

Wait Measuring::use_result() {
  const json::value newest = co_await cell_.panel.ask("campaign.get");
  if (!is_result(newest)) co_return;
  const json::object& campaign = result_of(newest).at("campaign").as_object();
  const json::object which{{"id", campaign.at("id")}};
  if (text_at(campaign, "kind") == "tool") {
    co_await orders_.give("tool.activate", which);
  } else if (text_at(campaign, "kind") == "calibration") {
    json::object again{{"id", campaign.at("id")}, {"loss", "huber"}, {"activate", random_.uniform() < 0.3}};
    co_await orders_.give("campaign.identify", std::move(again));
  } else if (random_.uniform() < 0.3) {
    json::object tool{{"number", kTool}};
    co_await orders_.give("tool.deactivate", std::move(tool));
  }
}

}  // namespace truepose::world
