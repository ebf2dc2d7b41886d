#pragma once

#include <functional>
#include <string_view>

namespace truepose::daemon {

enum class LogLevel { Info, Warning, Error };
std::string_view name(LogLevel level);  ///< "info", "warning", "error"

/// Opens the log on standard error, which is the journal under systemd. Not for the realtime thread.
///
/// @param level  "trace", "debug", "info", "warn" or "error"
void open_log(std::string_view level);
/// Writes what is still queued, for a second at most. What the reader has not taken by then is lost.
/// @return whether all of it is written; else nothing more can be, and the process ends by _exit()
[[nodiscard]] bool close_log();

void log(LogLevel level, std::string_view line);
inline void log_info(std::string_view line) { log(LogLevel::Info, line); }
inline void log_warning(std::string_view line) { log(LogLevel::Warning, line); }
inline void log_error(std::string_view line) { log(LogLevel::Error, line); }

/// Shows every further line to `reader` as well, in the thread that writes it; an empty one ends that. The
/// reader must not log.
void read_log(std::function<void(LogLevel level, std::string_view line)> reader);

}  // namespace truepose::daemon
