#include "daemon/service/service_manager.hpp"

#include <systemd/sd-daemon.h>

#include <cstdint>
#include <string>

namespace truepose::daemon {

void tell_ready(std::string_view status) { sd_notify(0, ("READY=1\nSTATUS=" + std::string{status}).c_str()); }
void tell_status(std::string_view status) { sd_notify(0, ("STATUS=" + std::string{status}).c_str()); }
std::optional<std::chrono::microseconds> watchdog_period() {
  std::uint64_t period_us = 0;
  if (sd_watchdog_enabled(0, &period_us) <= 0) return std::nullopt;
  return std::chrono::microseconds{period_us};
}
void tell_alive() { sd_notify(0, "WATCHDOG=1"); }
void tell_stopping() { sd_notify(0, "STOPPING=1\nSTATUS=stopping"); }

}  // namespace truepose::daemon
