#pragma once

#include <filesystem>

#include "proto/rsi/ethernet_config.hpp"

namespace truepose::config {

/// The RSI ethernet configuration that a controller loads (XML). Throws ConfigError.
rsi::EthernetConfig load_ethernet(const std::filesystem::path& file);

}  // namespace truepose::config
