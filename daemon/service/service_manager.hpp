#pragma once

#include <chrono>
#include <optional>
#include <string_view>

namespace truepose::daemon {

// What systemd is told (sd_notify). Without a service manager nothing happens.

/// The sockets are bound and requests are served.
void tell_ready(std::string_view status);
/// One line for `systemctl status`.
void tell_status(std::string_view status);
void tell_stopping();

/// Within which time the service manager wants to hear tell_alive() again, before it kills and restarts us;
/// nothing where it does not watch.
std::optional<std::chrono::microseconds> watchdog_period();
void tell_alive();

}  // namespace truepose::daemon
