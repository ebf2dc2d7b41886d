#include "proto/recording/ip_packet.hpp"

#include <arpa/inet.h>

#include <array>
#include <charconv>

namespace truepose::recording {
namespace {

constexpr std::size_t kIpHead = 20, kUdpHead = 8, kTcpHead = 20;
constexpr std::uint8_t kTcp = 6, kUdp = 17;

void put(std::string& out, std::uint32_t number, unsigned bytes) {
  while (bytes-- > 0) out += static_cast<char>(number >> (8 * bytes));
}

void put_at(std::string& out, std::size_t at, std::uint16_t number) {
  out[at] = static_cast<char>(number >> 8);
  out[at + 1] = static_cast<char>(number);
}

std::uint32_t get(std::string_view in, std::size_t at, unsigned bytes) {
  std::uint32_t number = 0;
  for (unsigned i = 0; i < bytes; ++i) number = number << 8 | static_cast<unsigned char>(in[at + i]);
  return number;
}

std::uint32_t sum_of(std::string_view bytes) {
  std::uint32_t sum = 0;
  for (std::size_t i = 0; i + 1 < bytes.size(); i += 2) sum += get(bytes, i, 2);
  return bytes.size() % 2 == 0 ? sum : sum + (get(bytes, bytes.size() - 1, 1) << 8);
}

/// The internet checksum (RFC 1071).
std::uint16_t checksum(std::uint32_t sum) {
  while (sum >> 16) sum = (sum & 0xffff) + (sum >> 16);
  return static_cast<std::uint16_t>(~sum);
}

}  // namespace

std::string text(const Endpoint& endpoint) {
  std::array<char, INET_ADDRSTRLEN> address{};
  const in_addr of{htonl(endpoint.address)};
  ::inet_ntop(AF_INET, &of, address.data(), address.size());
  return std::string{address.data()} + ':' + std::to_string(endpoint.port);
}

std::optional<Endpoint> read_endpoint(std::string_view text) {
  const std::size_t colon = text.rfind(':');
  if (colon == std::string_view::npos) return std::nullopt;
  Endpoint endpoint;
  const char* const end = text.data() + text.size();
  const auto [rest, error] = std::from_chars(text.data() + colon + 1, end, endpoint.port);
  if (error != std::errc{} || rest != end) return std::nullopt;
  in_addr address{};
  if (::inet_pton(AF_INET, std::string{text.substr(0, colon)}.c_str(), &address) == 1)
    endpoint.address = ntohl(address.s_addr);
  return endpoint;
}

std::string bytes_of(const IpPacket& packet) {
  const std::size_t head = packet.is_tcp ? kTcpHead : kUdpHead;
  const auto transport = static_cast<std::uint32_t>(head + packet.payload.size());
  std::string out;
  out.reserve(kIpHead + transport);
  put(out, 0x4500, 2);  // version 4, five words
  put(out, kIpHead + transport, 2);
  put(out, 0x00004000, 4);  // no identification, do not fragment
  put(out, 64, 1);          // time to live
  put(out, packet.is_tcp ? kTcp : kUdp, 1);
  put(out, 0, 2);
  put(out, packet.from.address, 4);
  put(out, packet.to.address, 4);
  put_at(out, 10, checksum(sum_of(out)));
  const std::uint32_t pseudo_head =
      sum_of(std::string_view{out}.substr(12, 8)) + (packet.is_tcp ? kTcp : kUdp) + transport;

  put(out, packet.from.port, 2);
  put(out, packet.to.port, 2);
  if (packet.is_tcp) {
    put(out, packet.sequence, 4);
    put(out, packet.acknowledged, 4);
    put(out, 0x5000u | packet.flags, 2);  // five words
    put(out, 0xffff, 2);                  // window
    put(out, 0, 4);                       // checksum, urgent pointer
  } else {
    put(out, transport, 2);
    put(out, 0, 2);
  }
  out += packet.payload;
  const std::uint16_t sum = checksum(pseudo_head + sum_of(std::string_view{out}.substr(kIpHead)));
  const bool is_none = sum == 0 && !packet.is_tcp;  // of UDP 0 would mean that there is no checksum
  put_at(out, kIpHead + (packet.is_tcp ? 16 : 6), is_none ? 0xffff : sum);
  return out;
}

std::optional<IpPacket> read_packet(std::string_view bytes) {
  if (bytes.size() < kIpHead || get(bytes, 0, 1) != 0x45 || get(bytes, 2, 2) != bytes.size())
    return std::nullopt;
  const std::uint32_t protocol = get(bytes, 9, 1);
  const std::size_t head = kIpHead + (protocol == kTcp ? kTcpHead : kUdpHead);
  if ((protocol != kTcp && protocol != kUdp) || bytes.size() < head) return std::nullopt;
  IpPacket packet{.from = {get(bytes, 12, 4), static_cast<std::uint16_t>(get(bytes, kIpHead, 2))},
                  .to = {get(bytes, 16, 4), static_cast<std::uint16_t>(get(bytes, kIpHead + 2, 2))},
                  .is_tcp = protocol == kTcp,
                  .payload = bytes.substr(head)};
  if (!packet.is_tcp) return packet;
  packet.sequence = get(bytes, kIpHead + 4, 4);
  packet.acknowledged = get(bytes, kIpHead + 8, 4);
  packet.flags = static_cast<std::uint8_t>(get(bytes, kIpHead + 13, 1));
  return packet;
}

}  // namespace truepose::recording
