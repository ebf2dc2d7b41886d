#pragma once

#include <expected>
#include <filesystem>
#include <string>

#include "proto/rsi/ethernet_config.hpp"

namespace truepose::daemon {

/// Reads the RSI ethernet configuration that the controller loads as well. The error is one sentence that
/// names the file.
std::expected<rsi::EthernetConfig, std::string> read_ethernet(const std::filesystem::path& file);

}  // namespace truepose::daemon
