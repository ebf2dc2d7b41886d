#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <boost/asio/awaitable.hpp>
#include <boost/json/serialize.hpp>
#include <chrono>
#include <cstdint>
#include <cstdlib>
#include <string>

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
  return all_trials() ? 30 : 0.125;
}

TEST_P(ASoak, KeepsEveryPromise) {
  SoakOptions options;
  options.seed = GetParam();
  options.days = days();
  options.production_h_per_day = days() < 1 ? 0.5 : 4;
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
