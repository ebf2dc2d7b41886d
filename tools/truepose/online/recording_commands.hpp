#pragma once

#include <filesystem>
#include <string>

#include "tools/truepose/online/online_commands.hpp"

namespace truepose::tools {

// Both throw CommandError, and ConfigError for files; both return the exit code.

/// Lets the daemon write a recording, and copies it.
/// @param out  empty: it stays with the daemon alone
int save_recording(const OnlineOptions& online, const std::filesystem::path& out);
int export_recording(const OnlineOptions& online, const std::string& name, const std::filesystem::path& out);

}  // namespace truepose::tools
