#pragma once

#include <string_view>

namespace truepose::daemon {

// What systemd is told (sd_notify). Without a service manager nothing happens.

/// The sockets are bound and requests are served.
void tell_ready(std::string_view status);
/// One line for `systemctl status`.
void tell_status(std::string_view status);
void tell_stopping();

}  // namespace truepose::daemon
