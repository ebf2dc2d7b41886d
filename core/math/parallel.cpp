#include "core/math/parallel.hpp"

#include <algorithm>
#include <atomic>
#include <exception>
#include <thread>
#include <vector>

#include "core/step_count.hpp"

namespace truepose {

void parallel_for(int count, int jobs, const std::function<void(int)>& work) {
  std::atomic<int> next{0};
  std::vector<std::exception_ptr> thrown(static_cast<std::size_t>(std::max(count, 0)));
  const auto take_turns = [&] {
    for (int i = next++; i < count; i = next++) {
      try {
        work(i);
      } catch (...) {
        thrown[static_cast<std::size_t>(i)] = std::current_exception();
        next = count;
      }
    }
  };
  {
    std::vector<std::jthread> threads;
    for (int k = 1; k < std::min(jobs, count); ++k) {
      threads.emplace_back([&, steps = step_count] {
        step_count = steps;
        take_turns();
      });
    }
    take_turns();
  }
  for (const std::exception_ptr& each : thrown) {
    if (each) std::rethrow_exception(each);
  }
}

int processor_count() { return std::max(1, static_cast<int>(std::thread::hardware_concurrency())); }

}  // namespace truepose
