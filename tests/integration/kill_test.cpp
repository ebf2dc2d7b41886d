// The daemon, killed at random instants of campaigns and of commands, and its PC without power.

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>

#include <algorithm>
#include <boost/json/object.hpp>
#include <boost/json/value.hpp>
#include <chrono>
#include <cstdio>
#include <map>
#include <random>
#include <set>
#include <thread>
#include <vector>

#include "proto/control/json_text.hpp"
#include "tests/integration/live_cell.hpp"
#include "tests/integration/power_cut.hpp"
#include "tests/trials.hpp"

namespace truepose {
namespace {

namespace json = boost::json;
using testing::AllOf;
using testing::HasSubstr;
using Random = std::mt19937_64;

/// Events of the campaigns of a cell.
struct Reported {
  std::map<std::string, std::set<std::int64_t>> points;  ///< poses measured, by campaign
  std::uint64_t last_event = 0;

  void note(const control::Event& event) {
    EXPECT_GT(event.seq, last_event) << "a number of an event came twice";
    last_event = event.seq;
    if (event.topic != "measurement" || event.data.at("p_mm").is_null()) return;
    const std::string id{event.data.at("campaign_id").as_string()};
    EXPECT_TRUE(points[id].insert(event.data.at("pose").as_int64()).second) << event.data;
  }
};

/// Every reported point is in the store.
void expect_kept(tools::RpcClient& client, const Reported& reported, const std::string& id) {
  std::set<std::int64_t> kept;
  for (std::size_t offset = 0;;) {
    const json::value page =
        called(client, "campaign.get", {{"id", id}, {"points_offset", offset}, {"points_limit", 50}});
    const json::array& points = page.at("points").as_array();
    for (const json::value& point : points) kept.insert(point.at("pose").as_int64());
    if (points.empty()) break;
    offset += points.size();
  }
  const auto of_campaign = reported.points.find(id);
  if (of_campaign == reported.points.end()) return;
  EXPECT_THAT(kept, testing::IsSupersetOf(of_campaign->second)) << id;
}

/// Goes on with the campaign that was interrupted, ends it, or begins another. @return its id
std::string command(tools::RpcClient& client, Random& random) {
  const json::value status = called(client, "cell.status");
  const json::array& interrupted = status.at("interrupted").as_array();
  EXPECT_LE(interrupted.size(), 1U);
  if (!interrupted.empty()) {
    const std::string id{interrupted.front().at("id").as_string()};
    const char* const method = random() % 8 == 0 ? "campaign.abort" : "campaign.resume";
    return std::string{called(client, method, {{"id", id}}).at("id").as_string()};
  }
  const json::object plan{{"identify_poses", 12}, {"validate_poses", 3}, {"remeasure", true}};
  return std::string{called(client, "campaign.start", plan).at("id").as_string()};
}

/// Begins a campaign and kills the daemon behind its first point.
void interrupt_a_campaign(LiveCell& cell, Reported& reported) {
  tools::RpcClient client = cell.client();
  called(client, "events.subscribe", {{"topics", json::array{"measurement"}}});
  called(client, "campaign.start", {{"identify_poses", 12}, {"validate_poses", 3}});
  const auto first = client.next_event();
  ASSERT_TRUE(first) << first.error().message << cell.daemon().errors();
  reported.note(*first);
  cell.daemon().send(SIGKILL);
  for (auto event = client.next_event(); event; event = client.next_event()) reported.note(*event);
  cell.daemon().wait();
  cell.start_daemon();
}

/// The id of the interrupted campaign; empty: there is none.
std::string interrupted_in(const LiveCell& cell) {
  tools::RpcClient client = cell.client();
  const json::value status = called(client, "cell.status");
  const json::array& interrupted = status.at("interrupted").as_array();
  return interrupted.empty() ? std::string{} : std::string{interrupted.front().at("id").as_string()};
}

/// An operator sees which campaign was interrupted and what to do, and does it.
void resume_by_the_command_line(const LiveCell& cell, const std::string& id) {
  const Finished status = cell.truepose({"status"});
  EXPECT_THAT(status.out, AllOf(HasSubstr("interrupted"), HasSubstr("truepose campaign resume " + id),
                                HasSubstr("truepose campaign abort " + id)));
  const Finished which = cell.truepose({"campaign", "resume"});
  EXPECT_EQ(which.exit_code, 1);
  EXPECT_THAT(which.err, HasSubstr("interrupted: calibration " + id));
  const Finished resumed = cell.truepose({"campaign", "resume", id, "--watch"});
  EXPECT_EQ(resumed.exit_code, 0) << resumed.err << resumed.out;
}

TEST(ADaemonKilledAtAnyInstant, KeepsWhatItHasReportedAndResumesItsCampaigns) {
  const std::uint64_t seed = std::random_device{}();
  std::printf("seed %llu\n", static_cast<unsigned long long>(seed));
  SCOPED_TRACE(testing::Message() << "seed " << seed);
  Random random{seed};
  LiveCell cell{{.speedup = 300}};
  Reported reported;
  int done = 0, power_cuts = 0, lost_writes = 0;
  std::vector<double> away_s;  // from the start of a daemon to its first answer
  std::string id;
  const int kills = all_trials() ? 200 : 8;
  for (int kill = 0; kill < kills && !testing::Test::HasFailure(); ++kill) {
    const auto started = std::chrono::steady_clock::now();
    cell.start_daemon(test::power_may_be_cut(cell.store_file()));
    tools::RpcClient client = cell.client();
    called(client, "cell.status");
    away_s.push_back(std::chrono::duration<double>(std::chrono::steady_clock::now() - started).count());
    if (!id.empty()) {
      const json::value campaign = called(client, "campaign.get", {{"id", id}}).at("campaign");
      const json::value& state = campaign.at("state");
      EXPECT_TRUE(state == "interrupted" || state == "done" || state == "aborted") << campaign;
      done += state == "done";
      expect_kept(client, reported, id);
    }
    called(client, "events.subscribe", {{"topics", json::array{"measurement", "campaign"}}});
    // From the moment of the command on, which may itself not be answered any more.
    std::jthread killer{[&cell, after = std::chrono::milliseconds{random() % 1000}] {
      std::this_thread::sleep_for(after);
      cell.daemon().send(SIGKILL);
    }};
    try {
      id = command(client, random);
    } catch (const std::runtime_error&) {
    }
    for (auto event = client.next_event(); event; event = client.next_event()) reported.note(*event);
    killer.join();
    EXPECT_EQ(cell.daemon().wait(), -1);
    if (random() % 2 != 0) continue;
    ++power_cuts;
    lost_writes += cell.cut_power(random);
  }

  cell.start_daemon();
  if (interrupted_in(cell).empty()) interrupt_a_campaign(cell, reported);
  const std::string last = interrupted_in(cell);
  resume_by_the_command_line(cell, last);
  tools::RpcClient client = cell.client();
  EXPECT_EQ(called(client, "campaign.get", {{"id", last}}).at_pointer("/campaign/state"), "done");
  expect_kept(client, reported, last);
  std::printf(
      "%d campaigns came to their end; with %d of the kills the power went, with %d writes not synced\n",
      done, power_cuts, lost_writes);
  std::ranges::sort(away_s);
  std::printf("a daemon that is started answers after %.2f s, at the latest after %.2f s\n",
              away_s[away_s.size() / 2], away_s.back());
}

}  // namespace
}  // namespace truepose
