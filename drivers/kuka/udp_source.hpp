#pragma once

#include <cstdint>
#include <expected>
#include <string>

namespace truepose::drivers {

/// An IPv4 address and a UDP port, both in the byte order of this machine.
struct UdpSource {
  std::uint32_t address = 0;
  std::uint16_t port = 0;
  friend bool operator==(const UdpSource&, const UdpSource&) = default;
};

/// "192.168.44.1:52000"
std::string text(const UdpSource& source);

/// The IPv4 address of a host, by its number or its name; or one sentence.
std::expected<std::uint32_t, std::string> ipv4_of(const std::string& host);

}  // namespace truepose::drivers
