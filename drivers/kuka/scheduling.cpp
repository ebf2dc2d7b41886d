#include "drivers/kuka/scheduling.hpp"

#include <sched.h>
#include <unistd.h>

#include <cerrno>
#include <charconv>
#include <cstring>
#include <fstream>
#include <string_view>

namespace truepose::drivers {
namespace {

std::string policy_name(int policy) {
  switch (policy) {
    case SCHED_FIFO:
      return "SCHED_FIFO";
    case SCHED_RR:
      return "SCHED_RR";
    case SCHED_BATCH:
      return "SCHED_BATCH";
    case SCHED_IDLE:
      return "SCHED_IDLE";
    case SCHED_OTHER:
      return "SCHED_OTHER";
  }
  return "unknown";
}

std::vector<int> cpus_of(pid_t thread) {
  cpu_set_t set;
  CPU_ZERO(&set);
  ::sched_getaffinity(thread, sizeof set, &set);
  std::vector<int> cpus;
  for (int cpu = 0; cpu < CPU_SETSIZE; ++cpu) {
    if (CPU_ISSET(static_cast<std::size_t>(cpu), &set)) cpus.push_back(cpu);
  }
  return cpus;
}

std::uint64_t locked_kB() {
  constexpr std::string_view kLocked = "VmLck:";
  std::ifstream status{"/proc/self/status"};
  for (std::string line; std::getline(status, line);) {
    if (!line.starts_with(kLocked)) continue;
    std::uint64_t kB = 0;
    const std::size_t begin = line.find_first_not_of(" \t", kLocked.size());
    if (begin != std::string::npos) std::from_chars(line.data() + begin, line.data() + line.size(), kB);
    return kB;
  }
  return 0;
}

}  // namespace

Scheduling scheduling_of(pid_t thread) {
  sched_param parameters{};
  ::sched_getparam(thread, &parameters);
  return {.policy = policy_name(::sched_getscheduler(thread)),
          .priority = parameters.sched_priority,
          .cpus = cpus_of(thread),
          .locked_kB = locked_kB()};
}

std::string describe(const Scheduling& scheduling) {
  std::string text = scheduling.policy;
  if (scheduling.priority > 0) text += ' ' + std::to_string(scheduling.priority);
  std::string_view before = " on CPU ";
  for (const int cpu : scheduling.cpus) {
    text.append(before).append(std::to_string(cpu));
    before = ", ";
  }
  return text + ", " + std::to_string(scheduling.locked_kB) + " kB locked";
}

std::optional<std::string> pin_to(int cpu) {
  cpu_set_t set;
  CPU_ZERO(&set);
  CPU_SET(static_cast<std::size_t>(cpu), &set);
  if (::sched_setaffinity(0, sizeof set, &set) == 0) return std::nullopt;
  if (errno != EINVAL) return "stream.cpu: CPU " + std::to_string(cpu) + ": " + std::strerror(errno);
  return "stream.cpu: this process has no CPU " + std::to_string(cpu) + ": the machine has " +
         std::to_string(::sysconf(_SC_NPROCESSORS_CONF)) +
         ", counted from 0; choose one that the unit allows, or leave stream.cpu out";
}

}  // namespace truepose::drivers
