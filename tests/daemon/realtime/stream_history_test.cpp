#include <gtest/gtest.h>

#include <cstdlib>

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

/// A cell that the seed makes up, and some seconds in which everything happens to it that can.
StreamHistory stream_history(std::uint64_t seed, const StreamCellOptions& options = {}) {
  StreamCell cell{seed, options};
  for (int cycle = 0; cycle < kCycles; ++cycle) cell.cycle();
  return cell.history();
}

TEST(StreamHistories, NeverMoveAnAxisFromWhatTheControllerHasInForceByMoreThanAStep) {
  StreamHistory sum;
  for (std::uint64_t seed = 1; seed <= histories(); ++seed) {
    const StreamHistory history = stream_history(seed);
    ASSERT_LE(history.greatest_step, 1) << "seed " << seed << ": " << history.worst;
    ASSERT_EQ(history.broken, "") << "seed " << seed << ": " << history.worst;
    sum.add(history);
  }
  const double answered = static_cast<double>(sum.answered) / static_cast<double>(sum.heard);
  std::printf(
      "%llu histories: %llu cycles, %.1f %% of what was heard answered, %llu sessions, %llu restarts of the "
      "daemon, %llu foreign datagrams, corrections up to %.2f deg; greatest step %.4f of the bound\n",
      static_cast<unsigned long long>(histories()), static_cast<unsigned long long>(sum.cycles),
      100 * answered, static_cast<unsigned long long>(sum.sessions),
      static_cast<unsigned long long>(sum.restarts), static_cast<unsigned long long>(sum.foreign),
      sum.greatest_correction_deg, sum.greatest_step);
  // A stream that never answers moves nothing either.
  EXPECT_GT(answered, 0.6);
  EXPECT_GT(sum.greatest_correction_deg, 2);
  EXPECT_GT(sum.greatest_step, 0.9) << "the histories ask for no speed";
}

/// With restarts of simulator, daemon and machine, repeated and lost frames, and corrections in effect that
/// the arm does not show yet.
TEST(StreamHistories, OfSimulatorsThatWaitForAReplyNeverMoveAnAxisByMoreThanAStepEither) {
  StreamHistory sum;
  for (std::uint64_t seed = 1; seed <= histories(); ++seed) {
    const StreamHistory history = stream_history(seed, {.waits = true});
    ASSERT_LE(history.greatest_step, 1) << "seed " << seed << ": " << history.worst;
    ASSERT_EQ(history.broken, "") << "seed " << seed << ": " << history.worst;
    sum.add(history);
  }
  const double answered = static_cast<double>(sum.answered) / static_cast<double>(sum.heard);
  std::printf(
      "%llu histories of simulators that wait: %llu frames, %.1f %% of what was heard answered, %llu sessions, %llu "
      "restarts of the daemon, corrections up to %.2f deg; greatest step %.4f of the bound\n",
      static_cast<unsigned long long>(histories()), static_cast<unsigned long long>(sum.cycles),
      100 * answered, static_cast<unsigned long long>(sum.sessions),
      static_cast<unsigned long long>(sum.restarts), sum.greatest_correction_deg, sum.greatest_step);
  EXPECT_GT(answered, 0.6) << "they are answered";
  EXPECT_GT(sum.greatest_correction_deg, 2);
  EXPECT_GT(sum.greatest_step, 0.9);
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
