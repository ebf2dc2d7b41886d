#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace truepose::recording {

/// One end of a connection (IPv4); 0.0.0.0:0 where it is not known.
struct Endpoint {
  std::uint32_t address = 0;
  std::uint16_t port = 0;
  bool operator==(const Endpoint&) const = default;
};
/// "192.168.0.20:7000"
std::string text(const Endpoint& endpoint);
/// Another address than IPv4 counts as 0.0.0.0. Nothing where there is no port.
std::optional<Endpoint> read_endpoint(std::string_view text);

enum TcpFlags : std::uint8_t { kFin = 1, kSyn = 2, kRst = 4, kPsh = 8, kAck = 16 };

/// A packet of UDP (RFC 768) or TCP (RFC 9293) over IPv4 (RFC 791), with its checksums.
struct IpPacket {
  Endpoint from, to;
  bool is_tcp = false;
  std::uint32_t sequence = 0, acknowledged = 0;  ///< of TCP
  std::uint8_t flags = 0;                        ///< of TCP
  std::string_view payload;                      ///< at most kMostPayload bytes
};
inline constexpr std::size_t kMostPayload = 65'535 - 20 - 20;

std::string bytes_of(const IpPacket& packet);
/// Nothing where the bytes are no such packet. The payload is a view of them.
std::optional<IpPacket> read_packet(std::string_view bytes);

}  // namespace truepose::recording
