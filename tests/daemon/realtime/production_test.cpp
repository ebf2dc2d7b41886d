// A customer's program under correction, as a whole: the shipped KRL, a controller and drives that share no
// code with the stream, an armed stream.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdio>

#include "tests/daemon/production_cell.hpp"
#include "tests/sanitized.hpp"
#include "tests/trials.hpp"

namespace truepose::daemon {
namespace {

using testing::IsEmpty;

constexpr double kBound_deg = 0.02 + 1e-6;  // max_step_deg, and the grid of the wire

void print(const Production& shift) {
  std::printf(
      "%d programs, %llu sessions, %.2f h: TCP at %d points %.3f mm (at most %.3f), without the stream %.3f "
      "(%.3f), %d points without all of it; largest step in force %.6f deg, correction up to %.2f deg, %d timeouts\n",
      shift.programs, static_cast<unsigned long long>(shift.sessions),
      static_cast<double>(shift.cycles) * 0.004 / 3600, shift.with.points, shift.with.mean_mm,
      shift.with.max_mm, shift.without.mean_mm, shift.without.max_mm, shift.points_without_it,
      shift.max_step_deg, shift.largest_deg, shift.timeouts);
}

struct ProductionProgramIn : testing::TestWithParam<AdvanceRun> {};

TEST_P(ProductionProgramIn, GluesWhereItWasTaughtThoughTheArmIsMillimetresWrong) {
  const Production shift = ProductionCell{20261123, {}, GetParam()}.shift(2);
  print(shift);
  EXPECT_EQ(shift.fault, "");
  EXPECT_THAT(shift.messages, IsEmpty());
  EXPECT_GE(shift.with.points, 200);
  EXPECT_GT(shift.without.mean_mm, 1);
  EXPECT_LT(shift.with.max_mm, 0.1);
  EXPECT_LE(shift.max_step_deg, kBound_deg);
  EXPECT_EQ(shift.left_deg, 0) << "a program closes RSI when no correction is in force any more";
  EXPECT_EQ(shift.sessions, 2u);
}

INSTANTIATE_TEST_SUITE_P(Either, ProductionProgramIn,
                         testing::Values(AdvanceRun::StopsAtVariables, AdvanceRun::PassesVariables));

/// A cell's programs with inline forms of the pendant, its own tools and bases, subprograms, triggers,
/// splines, an interrupt with BRAKE and RESUME.
struct PendantProgram : testing::TestWithParam<const char*> {};

TEST_P(PendantProgram, WorksWhereItWasTaughtThoughTheArmIsMillimetresWrong) {
  const Production shift = ProductionCell{20261129, {}, AdvanceRun::PassesVariables, GetParam()}.shift(2);
  print(shift);
  EXPECT_EQ(shift.fault, "");
  EXPECT_THAT(shift.messages, IsEmpty());
  EXPECT_EQ(shift.sessions, 2U);
  EXPECT_GE(shift.with.points, 6);
  EXPECT_GT(shift.without.mean_mm, 1);
  EXPECT_LT(shift.with.max_mm, 0.1);
  EXPECT_LE(shift.max_step_deg, kBound_deg);
  EXPECT_EQ(shift.left_deg, 0);
}

INSTANTIATE_TEST_SUITE_P(Of, PendantProgram,
                         testing::Values("palletising", "welding", "splines", "sequencer", "tool_change"),
                         [](const auto& each) { return each.param; });

/// Three hours of it and 200 sessions in an acceptance run, every day a tenth, less of it under a sanitizer.
TEST(ProductionProgram, IsCorrectedThroughEverythingThatHappensInAShift) {
  const bool whole = all_trials();
  const int programs = whole ? 200 : TRUEPOSE_SANITIZED ? 6 : 20;
  const Troubles troubles{.daemon_ends = whole ? 20 : 2,
                          .stops = whole ? 20 : 2,
                          .emergency_stops = whole ? 3 : 1,
                          .controller_restarts = whole ? 2 : 1,
                          .loss = 0.01};
  const Production shift = ProductionCell{20261124, troubles}.shift(programs);
  print(shift);
  EXPECT_EQ(shift.fault, "");
  const Troubles& left = shift.never_came;
  EXPECT_EQ(left.daemon_ends + left.stops + left.emergency_stops + left.controller_restarts, 0);
  EXPECT_GE(shift.sessions, static_cast<std::uint64_t>(programs));
  EXPECT_GT(shift.with.points, 75 * programs);
  EXPECT_LT(shift.with.max_mm, 0.1);
  EXPECT_LE(shift.max_step_deg, kBound_deg);
  EXPECT_EQ(shift.left_deg, 0);
}

}  // namespace
}  // namespace truepose::daemon
