#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "tools/truepose/doctor/observations.hpp"

namespace truepose::tools {

/// "192.168.44.0/24"
std::string network_text(const Interface& card);

/// "lo 127.0.0.1, eth0 192.168.44.10"
std::string addresses_text(const std::vector<Interface>& interfaces);

/// Rules for what comes in that drop or reject, where none accepts this UDP port by its number.
/// @param rules  as `nft list ruleset` and `iptables -S INPUT` print them
std::vector<std::string> dropping_rules(std::string_view rules, std::uint16_t port);

struct UdpPacket {
  drivers::UdpSource source, target;
  std::string_view payload;
};

/// A whole IPv4 packet that carries UDP and is no later fragment; else nothing.
std::optional<UdpPacket> read_udp(std::span<const std::byte> packet);

}  // namespace truepose::tools
