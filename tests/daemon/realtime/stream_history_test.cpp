#include <gtest/gtest.h>

#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <functional>

#include "tests/daemon/stream_cell.hpp"
#include "tests/sanitized.hpp"

namespace truepose::daemon {
namespace {

constexpr std::uint64_t kEveryday = TRUEPOSE_SANITIZED ? 100 : 1000;

/// How many histories: an acceptance run sets TRUEPOSE_STREAM_HISTORIES to 100000.
std::uint64_t histories() {
  const char* const count = std::getenv("TRUEPOSE_STREAM_HISTORIES");
  return count ? std::strtoull(count, nullptr, 10) : kEveryday;
}

constexpr int kCycles = 900;

/// Cells that seeds make up, and some time in which everything happens to them that can.
StreamHistory kept_histories(std::uint64_t count, std::uint64_t cycles,
                             const std::function<StreamCellOptions(std::uint64_t seed)>& options_of) {
  StreamHistory sum;
  for (std::uint64_t seed = 1; seed <= count; ++seed) {
    StreamCell cell{seed, options_of(seed)};
    for (std::uint64_t cycle = 0; cycle < cycles; ++cycle) cell.cycle();
    const StreamHistory history = cell.history();
    EXPECT_LE(history.greatest_step, 1) << "seed " << seed << ": " << history.worst;
    EXPECT_EQ(history.broken, "") << "seed " << seed << ": " << history.worst;
    if (testing::Test::HasFailure()) return sum;
    sum.add(history);
  }
  const double answered = static_cast<double>(sum.answered) / static_cast<double>(sum.heard);
  const auto number = [](std::uint64_t n) { return static_cast<unsigned long long>(n); };
  std::printf(
      "%llu histories: %llu cycles, %.1f %% of what was heard answered, %llu sessions, %llu restarts and %llu stalls "
      "of the daemon, %llu silences, %llu foreign datagrams, corrections up to %.2f deg; greatest step %.4f of the "
      "bound\n",
      number(count), number(sum.cycles), 100 * answered, number(sum.sessions), number(sum.restarts),
      number(sum.stalls), number(sum.silences), number(sum.foreign), sum.greatest_correction_deg,
      sum.greatest_step);
  // A stream that never answers moves nothing either.
  EXPECT_GT(answered, 0.6);
  EXPECT_GT(sum.greatest_correction_deg, 2);
  EXPECT_GT(sum.greatest_step, 0.9) << "the histories ask for no speed";
  return sum;
}

TEST(StreamHistories, NeverMoveAnAxisFromWhatTheControllerHasInForceByMoreThanAStep) {
  kept_histories(histories(), kCycles, [](std::uint64_t) { return StreamCellOptions{}; });
}

/// With restarts of simulator, daemon and machine, repeated and lost frames, and corrections in effect that
/// the arm does not show yet.
TEST(StreamHistories, OfSimulatorsThatWaitForAReplyNeverMoveAnAxisByMoreThanAStepEither) {
  kept_histories(histories(), kCycles, [](std::uint64_t) { return StreamCellOptions{.waits = true}; });
}

/// Of 4 and of 12 ms, with and without a person who starts the correction again after a silence. What befalls
/// them leaves the stream time to come to full correction in between.
TEST(StreamHistories, OfHoursWithLongGapsAndBacklogsNeverMoveAnAxisByMoreThanAStepEither) {
  constexpr std::uint64_t kCells = 4;
  const StreamHistory sum =
      kept_histories(kCells, histories() * kCycles / kCells, [](std::uint64_t seed) -> StreamCellOptions {
        return {.cycle_ms = seed % 2 == 0 ? 4 : 12,
                .rarity = 10,
                .longest_gap_cycles = 20'000,
                .longest_stall_cycles = 1000,
                .rearms = seed > kCells / 2};
      });
  for (const std::uint64_t happened : {sum.sessions, sum.restarts, sum.stalls, sum.silences, sum.foreign})
    EXPECT_GT(happened, 2U);
}

TEST(StreamCycleProperty, ComesToExactlyZeroAfterAnyHistory) {
  for (std::uint64_t seed = 101; seed <= 130; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    StreamCell cell{seed};
    for (int cycle = 0; cycle < kCycles; ++cycle) cell.cycle();
    cell.rest(2000);
    EXPECT_EQ(cell.in_force_deg(), test::Plant::Axes{});
    EXPECT_EQ(cell.status().value().state, StreamState::Idle) << cell.history().worst;
    EXPECT_EQ(cell.history().broken, "");
    if (HasFailure()) return;
  }
}

}  // namespace
}  // namespace truepose::daemon
