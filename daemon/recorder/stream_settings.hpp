#pragma once

#include <expected>
#include <map>
#include <string>

#include "daemon/realtime/stream_options.hpp"

namespace truepose::daemon {

/// The options of a stream by their names, each number in as many digits as bring it back exactly.
std::map<std::string, std::string> settings_of(const StreamOptions& options);
/// Error: one sentence that names the setting.
std::expected<StreamOptions, std::string> options_of(const std::map<std::string, std::string>& settings);

}  // namespace truepose::daemon
