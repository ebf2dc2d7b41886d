#pragma once

#include <sys/types.h>

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace truepose::drivers {

/// How a thread of this process runs, as the kernel tells it, whatever was asked for.
struct Scheduling {
  std::string policy;           ///< "SCHED_FIFO", "SCHED_OTHER"
  int priority = 0;             ///< 0 under ordinary scheduling
  std::vector<int> cpus;        ///< where it may run
  std::uint64_t locked_kB = 0;  ///< memory of the process that cannot be swapped out
};

/// @param thread  of this process, 0 = the caller
Scheduling scheduling_of(pid_t thread);

/// "SCHED_FIFO 80 on CPU 0, 1, 71234 kB locked"
std::string describe(const Scheduling& scheduling);

/// Keeps the calling thread on one CPU. @return why it cannot be there, in one sentence
std::optional<std::string> pin_to(int cpu);

}  // namespace truepose::drivers
