#include "daemon/ethernet_file.hpp"

#include <fstream>
#include <iterator>

namespace truepose::daemon {

std::expected<rsi::EthernetConfig, std::string> read_ethernet(const std::filesystem::path& file) {
  std::ifstream stream{file};
  if (!stream) return std::unexpected(file.string() + ": cannot be read");
  const std::string text{std::istreambuf_iterator<char>{stream}, {}};
  auto ethernet = rsi::parse_ethernet_config(text);
  if (!ethernet) return std::unexpected(file.string() + ": " + ethernet.error());
  return ethernet;
}

}  // namespace truepose::daemon
