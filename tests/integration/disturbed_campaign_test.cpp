// A campaign with three reflectors and four nests that continues through all that can happen in a night,
// compared with an undisturbed one.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>

#include <algorithm>
#include <boost/json/value.hpp>
#include <cmath>
#include <cstdio>
#include <deque>
#include <optional>
#include <random>
#include <set>
#include <string>

#include "tests/integration/live_cell.hpp"
#include "tests/integration/power_cut.hpp"
#include "tests/trials.hpp"

namespace truepose {
namespace {

namespace json = boost::json;

const int kIdentify = all_trials() ? 60 : 16;
const int kValidate = all_trials() ? 40 : 12;

const std::string kFourNests =
    "[{x: 1500, y: -1400, z: -800}, {x: 1800, y: 1500, z: -700}, {x: 3200, y: -1300, z: -1200}, "
    "{x: 2500, y: 1600, z: 600}]";
const std::string kTrackerOfScenario = "  reflector: CCR-1.5in                # how it names";
const std::string kTrackerOfCell = "  beam_radius_mm: 25 ";

/// @param speedup  what is steered lasts so many times shorter
LiveCell::Options three_reflectors(int seed, double speedup) {
  return {
      .speedup = speedup,
      .scenario =
          {{"#further_reflectors: [",
            "further_reflectors: [{offset_mm: {x: 118, y: -22, z: 154}, facing: {x: 0.6, y: -0.35, z: 0.71}, "
            "acceptance_deg: 30}, "},
           {kTrackerOfScenario, "  nests_mm: " + kFourNests + "\n" + kTrackerOfScenario}},
      .cell = {
          {"  seed: 0 ", "  seed: " + std::to_string(seed) + " "},
          {kTrackerOfCell, "  nests: " + kFourNests + "\n" + kTrackerOfCell},
          {"reflector:\n  name: \"1\"", "reflectors:\n  - name: a"},
          {"\n  offset_mm: {x: 60,", "\n    offset_mm: {x: 60,"},
          {"\n  facing: {x: 0.56, y: -0.43, z: 0.71}  #", "\n    facing: {x: 0.56, y: -0.43, z: 0.71}  #"},
          {"\n  acceptance_deg: 30 ", "\n    acceptance_deg: 30 "},
          {"#reflectors:\n",
           "  - {name: b, offset_mm: {x: -70, y: 40, z: 180}, facing: {x: -0.6, y: 0.4, z: 0.7}}\n"
           "  - {name: c, offset_mm: {x: 120, y: -20, z: 150}, facing: {x: 0.6, y: -0.35, z: 0.71}}\n"}}};
}

/// Something that happens once so many poses have been measured.
struct Trouble {
  enum class Kind { Steered, Killed, PowerCut } kind = Kind::Steered;
  std::size_t after = 0;
  json::object steering{};
};

/// Ten times somebody stands in the beam, the tracker restarts twice, the robot's link is cut three times,
/// the controller restarts, there is an emergency stop, the daemon is killed, and its PC loses its power.
std::deque<Trouble> a_bad_night(std::size_t poses) {
  std::deque<Trouble> troubles;
  const auto add = [&](double share, json::object steering) {
    troubles.push_back({.after = 1 + static_cast<std::size_t>(share * static_cast<double>(poses - 1)),
                        .steering = std::move(steering)});
  };
  for (int i = 0; i < 10; ++i) add(0.03 + 0.095 * i, {{"kind", "beam-break"}, {"lasts_ms", 3000}});
  for (const double share : {0.25, 0.7}) add(share, {{"kind", "tracker-restart"}});
  for (const double share : {0.15, 0.45, 0.8}) add(share, {{"kind", "eki-drop"}, {"lasts_ms", 6000}});
  add(0.9, {{"kind", "controller-restart"}, {"lasts_ms", 6000}});
  add(0.35, {{"kind", "emergency-stop"}, {"lasts_ms", 20'000}});
  const auto end = [&](double share, Trouble::Kind kind) {
    const double after = share * static_cast<double>(poses);
    troubles.push_back({.kind = kind, .after = static_cast<std::size_t>(after)});
  };
  end(0.4, Trouble::Kind::Killed);
  end(0.6, Trouble::Kind::PowerCut);
  std::ranges::stable_sort(troubles, {}, &Trouble::after);
  return troubles;
}

/// A campaign, and who watches it.
class Night {
 public:
  Night(int seed, std::deque<Trouble> troubles)
      : cell_{three_reflectors(seed, troubles.empty() ? 1000 : 100)},
        random_(static_cast<std::uint64_t>(seed)),
        troubles_{std::move(troubles)} {
    cell_.start_daemon(test::power_may_be_cut(cell_.store_file()));
    listen();
    id_ = ask("campaign.start",
              {{"identify_poses", kIdentify}, {"validate_poses", kValidate}, {"remeasure", false}})
              .at("id")
              .as_string();
  }

  void pass() {
    std::string phase;
    while (phase != "done" && phase != "failed" && phase != "aborted") {
      const auto event = client_->next_event();
      if (!event) throw std::runtime_error{event.error().message + cell_.daemon().errors()};
      if (event->topic == "measurement" && !event->data.at("p_mm").is_null()) note(event->data);
      if (event->topic == "campaign") phase = event->data.at("phase").as_string();
      // Where the beam stays away the campaign waits for somebody who has looked at the cell.
      if (event->topic == "cell" && event->data.at("state") == "paused") ask("campaign.resume");
      // The robot was cut off in the moment in which the campaign continued: an operator sees that and tries
      // again.
      if (phase == "interrupted" && event->topic == "cell" && event->data.at("state") == "fault") {
        ask("cell.acknowledge");
        ask("campaign.resume", {{"id", id_}});
        phase.clear();
      }
    }
    ASSERT_EQ(phase, "done") << cell_.daemon().errors();
    EXPECT_TRUE(troubles_.empty()) << troubles_.size() << " did not happen";
  }

  json::value campaign() { return ask("campaign.get", {{"id", id_}, {"points_limit", 0}}); }
  json::value report() { return ask("report.get", {{"id", id_}}).at("document"); }
  const std::set<std::int64_t>& poses() const { return poses_; }

 private:
  json::value ask(const std::string& method, const json::object& params = {}) {
    return called(*client_, method, params);
  }
  void listen() {
    client_.emplace(cell_.client());
    ask("events.subscribe", {{"topics", json::array{"campaign", "measurement", "cell"}}});
  }
  void note(const json::value& measurement) {
    poses_.insert(measurement.at("pose").as_int64());
    while (!troubles_.empty() && troubles_.front().after <= poses_.size()) {
      const Trouble trouble = std::move(troubles_.front());
      troubles_.pop_front();
      if (trouble.kind == Trouble::Kind::Steered) {
        cell_.steer(trouble.steering);
      } else {
        begin_daemon_again(trouble.kind == Trouble::Kind::PowerCut);
      }
    }
  }
  void begin_daemon_again(bool power_is_cut) {
    cell_.daemon().send(SIGKILL);
    for (auto event = client_->next_event(); event; event = client_->next_event())
      if (event->topic == "measurement" && !event->data.at("p_mm").is_null())
        poses_.insert(event->data.at("pose").as_int64());
    cell_.daemon().wait();
    if (power_is_cut) cell_.cut_power(random_);
    cell_.start_daemon(test::power_may_be_cut(cell_.store_file()));
    listen();
    EXPECT_GE(ask("campaign.get", {{"id", id_}, {"points_limit", 0}}).at("points_total").as_int64(),
              static_cast<std::int64_t>(poses_.size()))
        << "a reported point is missing";
    ask("campaign.resume", {{"id", id_}});
  }

  LiveCell cell_;
  std::mt19937_64 random_;
  std::optional<tools::RpcClient> client_;
  std::deque<Trouble> troubles_;
  std::string id_;
  std::set<std::int64_t> poses_;
};

/// Passes a night. @return the mean square of what is left at the poses that validate, mm^2
double passed(Night& night, std::size_t interruptions) {
  night.pass();
  const json::value report = night.report();
  const auto skipped = night.campaign().at("skipped").as_array().size();
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
  for (int seed = 0; seed < nights && !HasFailure(); ++seed) {
    Night without{seed, {}};
    quiet += passed(without, 0) / nights;
    Night with{seed, a_bad_night(static_cast<std::size_t>(kIdentify + kValidate))};
    bad += passed(with, 2) / nights;
  }
  std::printf("validation rms: %.4f mm in quiet nights, %.4f mm in bad ones\n", std::sqrt(quiet),
              std::sqrt(bad));
  // The few poses of one night tell their own error by a fifth.
  EXPECT_LT(std::sqrt(bad), widened(1.1, 0.4) * std::sqrt(quiet));
}

}  // namespace
}  // namespace truepose
