#include "daemon/ethernet_file.hpp"

#include "config/text_file.hpp"

namespace truepose::daemon {

namespace {

constexpr std::size_t kMostBytes = std::size_t{1} << 20;

}  // namespace

std::expected<rsi::EthernetConfig, std::string> read_ethernet(const std::filesystem::path& file) {
  try {
    auto ethernet = rsi::parse_ethernet_config(config::read_text_file(file, kMostBytes));
    if (!ethernet) return std::unexpected(file.string() + ": " + ethernet.error());
    return ethernet;
  } catch (const config::ConfigError& error) {
    return std::unexpected(error.what());
  }
}

}  // namespace truepose::daemon
