#include "config/ethernet_file.hpp"

#include <cstddef>
#include <utility>

#include "config/text_file.hpp"

namespace truepose::config {

rsi::EthernetConfig load_ethernet(const std::filesystem::path& file) {
  constexpr std::size_t kMostBytes = std::size_t{1} << 20;
  auto ethernet = rsi::parse_ethernet_config(read_text_file(file, kMostBytes));
  if (!ethernet) throw ConfigError(file.string() + ": " + ethernet.error());
  return *std::move(ethernet);
}

}  // namespace truepose::config
