#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <boost/asio/awaitable.hpp>
#include <boost/json/serialize.hpp>
#include <chrono>
#include <cstdint>
#include <cstdlib>
#include <set>
#include <string>
#include <string_view>
#include <utility>

#include "tests/trials.hpp"
#include "tests/world/cell.hpp"
#include "tests/world/people.hpp"
#include "tests/world/soak.hpp"

namespace truepose::world {
namespace {

namespace asio = boost::asio;
namespace json = boost::json;
using namespace std::chrono_literals;

void end_in_order(Cell& cell) {
  cell.pc.stop();
  cell.world.run([&] { return !cell.pc.runs(); });
  EXPECT_THAT(cell.panel.complaints, testing::IsEmpty());
}

struct Course {
  std::uint64_t hash = 0;
  std::string model;
};

asio::awaitable<void> calibrate_once(Cell& cell, Course& course) {
  co_await connect(cell);
  co_await calibrate(cell);
  const json::object now = co_await asked(cell, "cell.status");
  course.model = json::serialize(now.at("model"));
}

Course campaign_of(std::uint64_t seed) {
  Cell cell{seed};
  cell.pc.start();
  Course course;
  cell.world.play(calibrate_once(cell, course));
  end_in_order(cell);
  course.hash = cell.world.history.hash();
  return course;
}

TEST(AWorld, OfOneSeedHasOneHistory) {
  const Course one = campaign_of(1), again = campaign_of(1), other = campaign_of(2);
  EXPECT_NE(one.model, "null");
  EXPECT_EQ(one.hash, again.hash);
  EXPECT_EQ(one.model, again.model);
  EXPECT_NE(one.hash, other.hash);
}

// ---- A daemon that ends in the middle of a campaign ----

/// Points that were reported as measured: campaign, pose and position.
using Points = std::set<std::string>;

std::string point_text(std::string_view campaign, const json::object& point) {
  return std::string{campaign} + ' ' + json::serialize(point.at("pose")) + ' ' +
         json::serialize(point.at("p_mm"));
}

asio::awaitable<void> measure_while_it_dies(Cell& cell, bool by_power) {
  co_await connect(cell);
  const json::object begun = co_await start_campaign(cell);
  for (int death = 0; death < 3; ++death) {
    co_await cell.world.pass(std::chrono::seconds{20 + static_cast<int>(cell.world.random.uniform(0, 60))});
    by_power ? cell.pc.lose_power() : cell.pc.kill();
    co_await cell.world.pass(30s);
    cell.pc.start();
    co_await connect(cell);
    json::object which{{"id", begun.at("id")}};
    co_await asked(cell, "campaign.resume", std::move(which));
  }
  co_await campaign_over(cell);
}

asio::awaitable<void> read_points(Cell& cell, Points& points) {
  json::object all{{"limit", 1000}};
  const json::object answer = co_await asked(cell, "campaign.points", std::move(all));
  const std::string campaign{answer.at("id").as_string()};
  for (const json::value& point : answer.at("points").as_array()) {
    const json::object& measured = point.as_object();
    // Of poses that a resumption measured again nothing is reported.
    if (measured.at("purpose") != "check") points.insert(point_text(campaign, measured));
  }
}

TEST(ACampaign, OutlivesItsDaemonWithoutLosingAReportedPoint) {
  for (const bool by_power : {false, true}) {
    Cell cell{by_power ? 5U : 4U};
    Points reported, stored;
    cell.panel.on_event = [&](const json::object& event) {
      if (event.at("topic") != "measurement") return;
      const json::object& point = event.at("data").as_object();
      reported.insert(point_text(point.at("campaign_id").as_string(), point));
    };
    cell.pc.start();
    cell.world.play(measure_while_it_dies(cell, by_power));
    cell.world.play(read_points(cell, stored));
    end_in_order(cell);
    EXPECT_GE(reported.size(), 18U);
    EXPECT_EQ(stored, reported);
  }
}

// ---- An abort that the controller does not hear ----

asio::awaitable<double> turned_within(Cell& cell, drivers::Duration time) {
  const JointVector before = cell.devices.axes();
  co_await cell.world.pass(time);
  co_return (cell.devices.axes() - before).cwiseAbs().maxCoeff();
}

asio::awaitable<void> abort_behind_the_gate(Cell& cell) {
  co_await connect(cell);
  co_await start_campaign(cell);
  constexpr double kInMotion_rad = 0.01;
  for (double turned_rad = 0; turned_rad < kInMotion_rad;) turned_rad = co_await turned_within(cell, 50ms);
  config::ScenarioFault gate;
  gate.kind = config::ScenarioFault::Kind::GateOpen;
  gate.lasts = std::chrono::milliseconds{60s}.count();  // then the program is started again
  cell.devices.begin(gate);
  const json::object aborted = co_await asked(cell, "campaign.abort");
  EXPECT_EQ(aborted.at("reason").as_string(), "aborted by an operator");
  const double turned_rad = co_await turned_within(cell, 2min);
  EXPECT_EQ(turned_rad, 0);
  EXPECT_EQ(cell.devices.program().state, eki::ProgramState::Active);
  co_await calibrate(cell);
  const json::object now = co_await asked(cell, "cell.status");
  EXPECT_EQ(now.at("state").as_string(), "ready");
}

TEST(ACampaign, ThatIsAbortedBehindAnOpenGateDoesNotEndItsMoveOnceTheProgramIsStartedAgain) {
  Cell cell{5};
  cell.pc.start();
  cell.world.play(abort_behind_the_gate(cell));
  end_in_order(cell);
}

// ---- Everything at once ----

class ASoak : public testing::TestWithParam<std::uint64_t> {};

double days() {
  const char* const asked = std::getenv("TRUEPOSE_WORLD_DAYS");
  if (asked) return std::stod(asked);
  return all_trials() ? 30 : 1;
}

TEST_P(ASoak, KeepsEveryPromise) {
  SoakOptions options;
  options.seed = GetParam();
  options.days = days();
  options.production_h_per_day = 0.5;
  const SoakReport report = soak(options);
  for (const BrokenPromise& broken : report.broken)
    ADD_FAILURE() << time_text(broken.at) << ": " << broken.promise << "\nagain: soak --seed " << options.seed
                  << " --days " << options.days << " --production " << options.production_h_per_day
                  << " --trace all";
  EXPECT_GT(report.points, 0U);
}

INSTANTIATE_TEST_SUITE_P(Every, ASoak, testing::Range<std::uint64_t>(1, 11));

}  // namespace
}  // namespace truepose::world
