#pragma once

#include <string_view>

namespace truepose::daemon {

/// Opens the log on standard error, which is the journal under systemd. Not for the realtime thread.
///
/// @param level  "trace", "debug", "info", "warn" or "error"
void open_log(std::string_view level);
/// Writes what is still queued.
void close_log();

void log_info(std::string_view line);
void log_warning(std::string_view line);
void log_error(std::string_view line);

}  // namespace truepose::daemon
