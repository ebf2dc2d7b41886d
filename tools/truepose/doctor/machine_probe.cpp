#include <arpa/inet.h>
#include <ifaddrs.h>
#include <net/if.h>
#include <netinet/in.h>
#include <sched.h>
#include <sys/mman.h>
#include <sys/timex.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <memory>
#include <thread>

#include "tools/truepose/doctor/probes.hpp"

namespace truepose::tools {

namespace {

namespace fs = std::filesystem;

std::string line_of(const fs::path& file) {
  std::ifstream stream{file};
  std::string line;
  std::getline(stream, line);
  return line;
}

std::uint32_t ipv4(const sockaddr* address) {
  sockaddr_in in;
  std::memcpy(&in, address, sizeof in);
  return ntohl(in.sin_addr.s_addr);
}

/// Tries it in a thread of its own, which ends with it.
std::string why_no_fifo(int priority) {
  std::string refused;
  std::thread{[&] {
    const sched_param parameters{.sched_priority = priority};
    if (::sched_setscheduler(0, SCHED_FIFO, &parameters) != 0) refused = std::strerror(errno);
  }}.join();
  return refused;
}

std::string why_no_lock() {
  if (::mlockall(MCL_CURRENT) != 0) return std::strerror(errno);
  ::munlockall();
  return {};
}

std::vector<std::string> governors() {
  std::vector<std::string> found;
  std::error_code none;
  for (fs::directory_iterator cpu{"/sys/devices/system/cpu", none}, end; !none && cpu != end;
       cpu.increment(none)) {
    const std::string governor = line_of(cpu->path() / "cpufreq/scaling_governor");
    if (!governor.empty() && std::ranges::count(found, governor) == 0) found.push_back(governor);
  }
  return found;
}

bool is_clock_synchronised() {
  timex state{};
  return ::adjtimex(&state) != TIME_ERROR;
}

std::optional<std::uint64_t> free_bytes(const fs::path& store) {
  std::error_code unknown;
  const fs::space_info space = fs::space(fs::absolute(store).parent_path(), unknown);
  return unknown ? std::nullopt : std::optional<std::uint64_t>{space.available};
}

}  // namespace

std::vector<Interface> observe_interfaces() {
  ifaddrs* list = nullptr;
  if (::getifaddrs(&list) != 0) return {};
  const std::unique_ptr<ifaddrs, decltype(&::freeifaddrs)> all{list, &::freeifaddrs};
  std::vector<Interface> interfaces;
  for (const ifaddrs* card = list; card; card = card->ifa_next) {
    if (!card->ifa_addr || card->ifa_addr->sa_family != AF_INET) continue;
    interfaces.push_back({.name = card->ifa_name,
                          .address = ipv4(card->ifa_addr),
                          .mask = ipv4(card->ifa_netmask),
                          .up = (card->ifa_flags & IFF_UP) != 0,
                          .running = (card->ifa_flags & IFF_RUNNING) != 0});
  }
  return interfaces;
}

MachineObservation observe_machine(const config::CellConfig& cell) {
  return {.fifo_refused = why_no_fifo(cell.stream.priority),
          .lock_refused = why_no_lock(),
          .governors = governors(),
          .preempt_rt = line_of("/sys/kernel/realtime") == "1",
          .isolated = line_of("/sys/devices/system/cpu/isolated"),
          .clocksource = line_of("/sys/devices/system/clocksource/clocksource0/current_clocksource"),
          .clock_synchronised = is_clock_synchronised(),
          .store_free_bytes = free_bytes(cell.store)};
}

}  // namespace truepose::tools
