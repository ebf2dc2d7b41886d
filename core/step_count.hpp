#pragma once

#include <atomic>
#include <cstdint>

namespace truepose {

/// Where this thread counts the steps of its computation, for a watchdog; nowhere by default.
///
/// A thread's own rather than an argument: dozens of functions would pass it on that do not step themselves.
inline thread_local std::atomic<std::uint64_t>* step_count = nullptr;

/// Called in every loop that can take long, once a turn: a fit, a pose that is looked at, a fold of a
/// validation.
inline void count_step() {
  if (step_count != nullptr) step_count->fetch_add(1, std::memory_order_relaxed);
}

}  // namespace truepose
