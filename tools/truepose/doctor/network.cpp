#include "tools/truepose/doctor/network.hpp"

#include <bit>
#include <sstream>

namespace truepose::tools {

namespace {

std::string dotted(std::uint32_t address) {
  std::string with_port = text(drivers::UdpSource{address, 0});
  return with_port.substr(0, with_port.find(':'));
}

bool has_any(std::string_view line, std::initializer_list<std::string_view> words) {
  for (const std::string_view word : words) {
    if (line.contains(word)) return true;
  }
  return false;
}

std::uint32_t big_endian(std::span<const std::byte> bytes, std::size_t at, std::size_t size) {
  std::uint32_t number = 0;
  for (std::size_t i = 0; i < size; ++i) number = number << 8 | std::to_integer<std::uint32_t>(bytes[at + i]);
  return number;
}

}  // namespace

std::string network_text(const Interface& card) {
  return dotted(card.address & card.mask) + "/" + std::to_string(std::popcount(card.mask));
}

std::string addresses_text(const std::vector<Interface>& interfaces) {
  std::string list;
  for (const Interface& card : interfaces)
    list += (list.empty() ? "" : ", ") + card.name + " " + dotted(card.address);
  return list;
}

// The text does not show which of many rules decides: all that may are named for the operator.
std::vector<std::string> dropping_rules(std::string_view rules, std::uint16_t port) {
  std::vector<std::string> dropping;
  std::istringstream lines{std::string{rules}};
  const std::string number = std::to_string(port);
  bool inwards = true;  // nft tells the direction of a chain in its first line
  for (std::string line; std::getline(lines, line);) {
    const std::size_t begin = line.find_first_not_of(" \t");
    if (begin == std::string::npos) continue;
    line.erase(0, begin);
    if (line.starts_with("chain ") || line.starts_with("-")) inwards = true;
    if (line.contains(" hook ")) inwards = has_any(line, {"hook input", "hook prerouting", "hook ingress"});
    if (!inwards) continue;
    if (line.contains(number) && has_any(line, {"accept", "ACCEPT"})) return {};
    if (has_any(line,
                {"policy drop", "INPUT DROP", "INPUT REJECT", " drop", " reject", "-j DROP", "-j REJECT"}))
      dropping.push_back(line);
  }
  return dropping;
}

std::optional<UdpPacket> read_udp(std::span<const std::byte> packet) {
  constexpr std::size_t kLeastHeader = 20, kUdpHeader = 8;
  constexpr std::uint32_t kUdp = 17, kOffset = 0x1fff;
  if (packet.size() < kLeastHeader || big_endian(packet, 0, 1) >> 4 != 4) return std::nullopt;
  const std::size_t header = (big_endian(packet, 0, 1) & 0xf) * 4;
  const bool first = (big_endian(packet, 6, 2) & kOffset) == 0;
  if (big_endian(packet, 9, 1) != kUdp || !first || header < kLeastHeader ||
      packet.size() < header + kUdpHeader)
    return std::nullopt;
  const auto payload = packet.subspan(header + kUdpHeader);
  const auto port = [&](std::size_t at) {
    return static_cast<std::uint16_t>(big_endian(packet, header + at, 2));
  };
  return UdpPacket{{big_endian(packet, 12, 4), port(0)},
                   {big_endian(packet, 16, 4), port(2)},
                   {reinterpret_cast<const char*>(payload.data()), payload.size()}};
}

}  // namespace truepose::tools
