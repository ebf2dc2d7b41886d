#include "tests/daemon/plant.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>
#include <limits>
#include <stdexcept>

#include "tests/allocations.hpp"

namespace truepose::test {
namespace {

using Axes = Plant::Axes;

constexpr Axes kStart{10, -80, 90, 20, 45, -30};

Axes plus(Axes axes, double deg) {
  for (double& axis : axes) axis += deg;
  return axes;
}

Axes all(double deg) { return plus({}, deg); }

/// One cycle that is answered with this correction.
Plant::Sent answered(Plant& plant, const Axes& aspos_deg, const Axes& correction_deg) {
  const Plant::Sent sent = plant.begin_cycle(aspos_deg).value();
  EXPECT_TRUE(plant.take_reply(sent.ipoc, correction_deg));
  plant.end_cycle();
  return sent;
}

Plant::State unanswered(Plant& plant) {
  plant.begin_cycle(kStart);
  return plant.end_cycle();
}

TEST(Plant, MovesTheAxesByACorrectionInTheNextCycleAndKeepsTheSetPointWithoutIt) {
  Plant plant{{}};
  EXPECT_EQ(answered(plant, kStart, all(0.5)).aipos_deg, kStart);
  const Plant::Sent sent = answered(plant, kStart, all(0.5));
  EXPECT_EQ(sent.aspos_deg, kStart);
  EXPECT_EQ(sent.aipos_deg, plus(kStart, 0.5));
}

TEST(Plant, CountsItsClockInStepsOfTheCycle) {
  Plant plant{{.cycle_ms = 12, .ipoc_step = 12, .first_ipoc = 1000}};
  EXPECT_EQ(answered(plant, kStart, {}).ipoc, 1000u);
  EXPECT_EQ(answered(plant, kStart, {}).ipoc, 1012u);
}

TEST(Plant, FollowsACorrectionAfterItsDeadTimeAndThenByItsLag) {
  Plant plant{{.cycle_ms = 4, .dead_time_ms = 12, .lag_ms = 40}};
  answered(plant, kStart, all(1));
  for (int cycle = 0; cycle < 3; ++cycle) {
    EXPECT_EQ(answered(plant, kStart, all(1)).aipos_deg, kStart) << cycle << " cycles after it";
  }
  for (int cycle = 1; cycle <= 10; ++cycle) {
    const double covered = answered(plant, kStart, all(1)).aipos_deg[0] - kStart[0];
    EXPECT_NEAR(covered, 1 - std::exp(-cycle * 4 / 40.0), 1e-12) << cycle << " cycles after the dead time";
  }
}

TEST(Plant, StaysBehindASteadyMotionByDeadTimeAndLag) {
  Plant plant{{.cycle_ms = 4, .dead_time_ms = 14, .lag_ms = 60}};
  constexpr double kDegPerCycle = 0.2;  // 50 deg/s
  double behind_deg = 0;
  for (int cycle = 0; cycle < 500; ++cycle) {
    const Plant::Sent sent = answered(plant, plus(kStart, cycle * kDegPerCycle), {});
    behind_deg = sent.aspos_deg[0] - sent.aipos_deg[0];
  }
  // The lag of a sampled step response: exp(-T/tau) / (1 - exp(-T/tau)) cycles.
  const double kept = std::exp(-4.0 / 60);
  EXPECT_NEAR(behind_deg, kDegPerCycle * (14.0 / 4 + kept / (1 - kept)), 1e-9);
  EXPECT_NEAR(behind_deg, 50 * 0.074, 0.11);
}

TEST(Plant, LetsAnAxisLagMoreThanAnother) {
  Plant plant{{.lag_ms = 40, .axis_lag_scale = {0, 1, 1, 1, 1, 2}}};
  answered(plant, kStart, all(1));
  const Plant::Sent sent = answered(plant, kStart, all(1));
  EXPECT_EQ(sent.aipos_deg[0], kStart[0] + 1);
  EXPECT_NEAR(sent.aipos_deg[5] - kStart[5], 1 - std::exp(-0.05), 1e-12);
}

TEST(Plant, TakesOnlyTheFirstAnswerToTheCycleUnderWay) {
  Plant plant{{}};
  const std::uint64_t before = plant.begin_cycle(kStart)->ipoc;
  plant.end_cycle();
  const std::uint64_t ipoc = plant.begin_cycle(kStart)->ipoc;
  EXPECT_FALSE(plant.take_reply(before, all(1)));
  EXPECT_FALSE(plant.take_reply(ipoc + 4, all(1)));
  EXPECT_FALSE(plant.take_reply(ipoc, all(std::numeric_limits<double>::quiet_NaN())));
  EXPECT_TRUE(plant.take_reply(ipoc, all(0.25)));
  EXPECT_FALSE(plant.take_reply(ipoc, all(1)));
  EXPECT_EQ(plant.end_cycle().in_force_deg, all(0.25));
  EXPECT_FALSE(plant.take_reply(ipoc, all(1))) << "the cycle has ended";
}

TEST(Plant, HoldsOrDropsTheCorrectionOfAnUnansweredCycleAsHoldOnSays) {
  Plant holding{{.holdon = true}};
  answered(holding, kStart, all(1.2));
  EXPECT_EQ(unanswered(holding).in_force_deg, all(1.2));

  Plant dropping{{.holdon = false}};
  answered(dropping, kStart, all(1.2));
  const Plant::State state = unanswered(dropping);
  EXPECT_EQ(state.in_force_deg, all(0));
  EXPECT_EQ(state.step_deg, 1.2);
}

TEST(Plant, ReportsTheGreatestChangeOfAnAxisInACycle) {
  Plant plant{{}};
  plant.take_reply(plant.begin_cycle(kStart)->ipoc, {0.1, -0.3, 0, 0, 0, 0.2});
  EXPECT_EQ(plant.end_cycle().step_deg, 0.3);
  plant.take_reply(plant.begin_cycle(kStart)->ipoc, {0.1, 0.3, 0, 0, 0, 0.2});
  EXPECT_EQ(plant.end_cycle().step_deg, 0.6);
}

TEST(Plant, ClampsCorrectionsAtTheLimitOfTheAxis) {
  Plant plant{{.axis_corr_limit_deg = 2}};
  answered(plant, kStart, {3, -3, 1, 0, 0, 0});
  EXPECT_EQ(plant.in_force_deg(), (Axes{2, -2, 1, 0, 0, 0}));
}

TEST(Plant, AcceptsACorrectionThatItIgnores) {
  Plant plant{{.ignores_correction = true}};
  answered(plant, kStart, all(1));
  EXPECT_EQ(plant.in_force_deg(), all(0));
  EXPECT_EQ(answered(plant, kStart, all(1)).aipos_deg, kStart);
}

TEST(Plant, CountsUnansweredCyclesAsItsDelaySays) {
  Plant cumulative{{.delay = Count::Cumulative}};
  Plant consecutive{{.delay = Count::Consecutive}};
  Plant without{{.delay = Count::None}};
  for (Plant* plant : {&cumulative, &consecutive, &without}) {
    unanswered(*plant);
    unanswered(*plant);
    answered(*plant, kStart, {});
    unanswered(*plant);
  }
  EXPECT_EQ(cumulative.begin_cycle(kStart)->delay, 3);
  EXPECT_EQ(consecutive.begin_cycle(kStart)->delay, 1);
  EXPECT_EQ(without.begin_cycle(kStart)->delay, std::nullopt);
}

TEST(Plant, EndsAtItsTimeoutAndSendsNothingAnyMore) {
  Plant in_a_row{{.timeout_cycles = 3}};
  Plant in_all{{.timeout_cycles = 3, .timeout_counts = Count::Cumulative}};
  for (Plant* plant : {&in_a_row, &in_all}) {
    unanswered(*plant);
    unanswered(*plant);
    answered(*plant, kStart, all(0.1));
    unanswered(*plant);
  }
  EXPECT_TRUE(in_a_row.alive());
  EXPECT_FALSE(in_all.alive());
  EXPECT_FALSE(in_all.begin_cycle(kStart));
  EXPECT_TRUE(unanswered(in_a_row).alive);
  EXPECT_FALSE(unanswered(in_a_row).alive);
}

TEST(Plant, RestartsWithNothingInForceWhereTheArmStands) {
  Plant plant{{.lag_ms = 40, .timeout_cycles = 1}};
  for (int cycle = 0; cycle < 100; ++cycle) answered(plant, kStart, all(1));
  const std::uint64_t last = answered(plant, kStart, all(1)).ipoc;
  EXPECT_FALSE(unanswered(plant).alive);

  plant.restart_session({.pause_cycles = 5, .source_port = 50'000});
  for (int cycle = 0; cycle < 5; ++cycle) {
    EXPECT_FALSE(plant.begin_cycle(kStart));
    EXPECT_EQ(plant.end_cycle().step_deg, 0);
  }
  const Plant::Sent sent = plant.begin_cycle(plus(kStart, 1)).value();
  EXPECT_EQ(sent.ipoc, last + 4 + 6 * 4) << "one unanswered, then the pause";
  EXPECT_EQ(sent.aipos_deg, plus(kStart, 1));
  EXPECT_EQ(sent.delay, 0);
  EXPECT_EQ(sent.source_port, 50'000);
  EXPECT_EQ(plant.in_force_deg(), all(0));
}

TEST(Plant, RestartsAtAnotherTimeStampOnRequest) {
  Plant plant{{}};
  answered(plant, kStart, all(1));
  plant.restart_session({.pause_cycles = 3, .ipoc = 1000});
  for (int cycle = 0; cycle < 3; ++cycle) EXPECT_FALSE(plant.begin_cycle(kStart));
  EXPECT_EQ(plant.begin_cycle(kStart)->ipoc, 1000u);
}

TEST(Plant, ComesDownFromItsOldCorrectionWhereTheArmHasNotSettled) {
  Plant plant{{.lag_ms = 40}};
  for (int cycle = 0; cycle < 200; ++cycle) answered(plant, kStart, all(1));
  plant.restart_session({.pause_cycles = 2, .arm_settled = false});
  plant.begin_cycle(kStart);
  plant.begin_cycle(kStart);
  EXPECT_NEAR(plant.begin_cycle(kStart)->aipos_deg[0] - kStart[0], std::exp(-3 * 4 / 40.0), 1e-6);
}

TEST(Plant, RefusesADeadTimeThatItCannotRemember) {
  EXPECT_NO_THROW(Plant{{.dead_time_ms = 100}});
  EXPECT_THROW((Plant{{.cycle_ms = 4, .dead_time_ms = 1000}}), std::invalid_argument);
  EXPECT_THROW((Plant{{.lag_ms = -1}}), std::invalid_argument);
}

TEST(Plant, AllocatesNothingInItsCycle) {
  Plant plant{{.dead_time_ms = 30, .lag_ms = 40}};
  const auto before = allocations();
  for (int cycle = 0; cycle < 1000; ++cycle) answered(plant, kStart, all(0.1));
  plant.restart_session({});
  EXPECT_EQ(allocations(), before);
}

}  // namespace
}  // namespace truepose::test
