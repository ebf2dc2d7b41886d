#pragma once

#include <filesystem>

#include "tools/truepose/online/online_commands.hpp"

namespace truepose::tools {

/// Lets the daemon copy its store, and brings the copy to a file here, for its owner alone, which is checked
/// and then appears whole, or not at all. Throws CommandError, and ConfigError for the file.
int back_up(const OnlineOptions& online, const std::filesystem::path& out);

}  // namespace truepose::tools
