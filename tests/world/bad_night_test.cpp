// A campaign with three reflectors and four nests through all that can happen in a night, compared with an
// undisturbed one.
#include <gtest/gtest.h>

#include <algorithm>
#include <boost/asio/awaitable.hpp>
#include <boost/json/object.hpp>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <deque>
#include <functional>
#include <set>
#include <string>
#include <utility>

#include "tests/trials.hpp"
#include "tests/world/answers.hpp"
#include "tests/world/cell.hpp"
#include "tests/world/people.hpp"

namespace truepose::world {
namespace {

namespace asio = boost::asio;
namespace json = boost::json;
using namespace std::chrono_literals;

const int kIdentify = all_trials() ? 60 : 16;
const int kValidate = all_trials() ? 40 : 12;

void equip(config::CellConfig& cell, config::Scenario& scenario) {
  const Eigen::Vector3d b_mm{-70, 40, 180}, b_faces{-0.6, 0.4, 0.7};
  cell.reflector.name = "a";
  cell.further_reflectors = {{.name = "b", .p_FS_mm = b_mm, .facing_F = b_faces},
                             {.name = "c", .p_FS_mm = {120, -20, 150}, .facing_F = {0.6, -0.35, 0.71}}};
  scenario.further_reflectors = {{.p_FS_mm = {118, -22, 154}, .facing_F = {0.6, -0.35, 0.71}},
                                 {.p_FS_mm = b_mm, .facing_F = b_faces}};
  cell.tracker.nests_mm = scenario.instrument.nests_mm = {
      {1500, -1400, -800}, {1800, 1500, -700}, {3200, -1300, -1200}, {2500, 1600, 600}};
  // As the scenario has it. The shipped cell file states less of a nest nearby, which then seems to move.
  cell.tracker.noise = {.range_mm = scenario.noise.range_mm, .transverse_mm = scenario.noise.transverse_mm};
}

/// Something that happens once this share of the poses has been measured.
struct Trouble {
  double share;
  std::function<void(Cell&)> happen;
};

using Troubles = std::deque<Trouble>;

/// Ten times a person stands in the beam, the tracker restarts twice, the robot's link is cut three times,
/// the controller restarts, there is an emergency stop, the daemon is killed, and its PC loses its power.
Troubles a_bad_night() {
  using Kind = config::ScenarioFault::Kind;
  Troubles troubles;
  const auto add = [&](double share, Kind kind, std::chrono::milliseconds lasts) {
    config::ScenarioFault fault;
    fault.kind = kind;
    fault.lasts = lasts.count();
    troubles.push_back({share, [fault](Cell& cell) { cell.devices.begin(fault); }});
  };
  for (int i = 0; i < 10; ++i) add(0.03 + 0.095 * i, Kind::BeamBreak, 10s);
  for (const double share : {0.25, 0.7}) add(share, Kind::TrackerRestart, 1ms);
  for (const double share : {0.15, 0.45, 0.8}) add(share, Kind::EkiDrop, 6s);
  add(0.9, Kind::ControllerRestart, 6s);
  add(0.35, Kind::EmergencyStop, 20s);
  troubles.push_back({0.4, [](Cell& cell) { cell.pc.kill(); }});
  troubles.push_back({0.6, [](Cell& cell) { cell.pc.lose_power(); }});
  std::ranges::stable_sort(troubles, {}, &Trouble::share);
  return troubles;
}

/// What is left of one.
struct Night {
  std::string id;                ///< of its campaign
  std::set<std::int64_t> poses;  ///< measured
  Troubles to_come;
  json::object report, campaign;
};

/// An operator, who looks every second, and does what a cell needs to measure on.
asio::awaitable<bool> keep_measuring(Cell& cell, std::string id) {
  if (!cell.pc.runs()) {
    cell.pc.start();
    co_await connect(cell);
  }
  const json::object now = co_await asked(cell, "cell.status");
  json::object which{{"id", id}};
  if (!now.at("faults").as_array().empty()) co_await cell.panel.ask("cell.acknowledge");
  if (now.at("state") == "paused") co_await cell.panel.ask("campaign.resume");
  if (!now.at("interrupted").as_array().empty()) co_await cell.panel.ask("campaign.resume", std::move(which));
  co_return !now.at("campaign").is_null() || !now.at("interrupted").as_array().empty();
}

asio::awaitable<void> pass_night(Cell& cell, Night& night) {
  co_await connect(cell);
  json::object plan{{"identify_poses", kIdentify}, {"validate_poses", kValidate}, {"remeasure", false}};
  const json::object begun = co_await asked(cell, "campaign.start", std::move(plan));
  night.id = text_at(begun, "id");
  const drivers::TimePoint morning = cell.world.clock.now() + 12h;
  for (bool measures = true; measures && cell.world.clock.now() < morning;) {
    co_await cell.world.pass(1s);
    Troubles& next = night.to_come;
    const auto measured = static_cast<double>(night.poses.size());
    for (; !next.empty() && next.front().share * (kIdentify + kValidate) <= measured; next.pop_front())
      next.front().happen(cell);
    measures = co_await keep_measuring(cell, night.id);
  }
  json::object which{{"id", night.id}, {"points_limit", 0}}, same{{"id", night.id}};
  night.campaign = co_await asked(cell, "campaign.get", std::move(which));
  night.report = co_await asked(cell, "report.get", std::move(same));
}

/// Passes a night. @return the mean square of what is left at the poses that validate, mm^2
double passed(std::uint64_t seed, Troubles troubles, std::size_t interruptions) {
  Cell cell{seed, [&](config::CellConfig& config, config::Scenario& scenario) {
              equip(config, scenario);
              config.campaign.seed = seed;
            }};
  Night night{.id = {}, .poses = {}, .to_come = std::move(troubles), .report = {}, .campaign = {}};
  cell.panel.on_event = [&](const json::object& event) {
    if (event.at("topic") != "measurement") return;
    const json::object& point = event.at("data").as_object();
    if (!point.at("p_mm").is_null()) night.poses.insert(point.at("pose").as_int64());
  };
  cell.pc.start();
  cell.world.play(pass_night(cell, night));
  EXPECT_EQ(text_at(night.campaign.at("campaign").as_object(), "state"), "done");
  EXPECT_TRUE(night.to_come.empty()) << night.to_come.size() << " did not happen";
  const json::value& report = night.report.at("document");
  const auto skipped = night.campaign.at("skipped").as_array().size();
  EXPECT_EQ(report.at_pointer("/identify/poses"), kIdentify) << skipped << " were given up";
  EXPECT_EQ(report.at_pointer("/validate/poses"), kValidate) << skipped << " were given up";
  const json::value* const found = report.as_object().if_contains("interruptions");
  EXPECT_EQ(found ? found->as_array().size() : 0, interruptions);
  const double rms_mm = report.at_pointer("/validate/after/rms").to_number<double>();
  return rms_mm * rms_mm;
}

TEST(ACampaignThroughABadNight, MeasuresEveryPoseOrASubstituteAndIsAsGoodAsOneOfAQuietNight) {
  const int nights = all_trials() ? 4 : 1;
  double quiet = 0, bad = 0;
  for (int night = 0; night < nights && !HasFailure(); ++night) {
    const auto seed = static_cast<std::uint64_t>(night);
    quiet += passed(seed, {}, 0) / nights;
    bad += passed(seed, a_bad_night(), 2) / nights;
  }
  std::printf("validation rms: %.4f mm in quiet nights, %.4f mm in bad ones\n", std::sqrt(quiet),
              std::sqrt(bad));
  // The few poses of one night tell their own error by a fifth.
  EXPECT_LT(std::sqrt(bad), widened(1.1, 0.4) * std::sqrt(quiet));
}

}  // namespace
}  // namespace truepose::world
