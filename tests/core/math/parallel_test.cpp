#include "core/math/parallel.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <cstdint>
#include <latch>
#include <numeric>
#include <stdexcept>
#include <string>
#include <vector>

#include "core/step_count.hpp"

namespace truepose {
namespace {

TEST(ParallelFor, DoesEachOnceWithAnyNumberOfJobs) {
  constexpr int kCount = 1000;
  for (const int jobs : {1, 2, 3, 2000}) {
    std::vector<int> done(kCount);
    parallel_for(kCount, jobs, [&](int i) { done[static_cast<std::size_t>(i)] += i; });
    std::vector<int> expected(kCount);
    std::iota(expected.begin(), expected.end(), 0);
    EXPECT_EQ(done, expected) << jobs << " jobs";
  }
}

TEST(ParallelFor, DoesAsManyAtATimeAsThereAreJobs) {
  std::latch all_begun(3);  // of fewer threads the first would wait for ever
  parallel_for(3, 3, [&](int) { all_begun.arrive_and_wait(); });
}

TEST(ParallelFor, DoesNothingWhereThereIsNothingToDo) {
  parallel_for(0, 2, [](int) { FAIL(); });
}

TEST(ParallelFor, ThrowsWhatTheLowestThrewWithAnyNumberOfJobs) {
  for (const int jobs : {1, 4}) {
    try {
      parallel_for(100, jobs, [](int i) {
        if (i % 10 == 7) throw std::runtime_error(std::to_string(i));
      });
      FAIL() << "nothing was thrown";
    } catch (const std::runtime_error& error) {
      EXPECT_STREQ(error.what(), "7") << jobs << " jobs";
    }
  }
}

TEST(ParallelFor, LeavesWhatFollowsAFailureUndone) {
  int done = 0;
  EXPECT_THROW(parallel_for(100, 1,
                            [&](int i) {
                              if (i == 3) throw std::runtime_error("");
                              ++done;
                            }),
               std::runtime_error);
  EXPECT_EQ(done, 3);
}

TEST(ParallelFor, CountsTheStepsOfAllItsThreadsWhereTheCallingOneDoes) {
  std::atomic<std::uint64_t> steps{0};
  step_count = &steps;
  parallel_for(50, 3, [](int) { count_step(); });
  step_count = nullptr;
  EXPECT_EQ(steps, 50u);
}

}  // namespace
}  // namespace truepose
