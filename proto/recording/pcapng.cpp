#include "proto/recording/pcapng.hpp"

#include <cstring>
#include <type_traits>

namespace truepose::recording {
namespace {

constexpr std::uint32_t kSection = 0x0a0d0d0a, kInterface = 1, kEnhancedPacket = 6;
constexpr std::uint32_t kByteOrder = 0x1a2b3c4d;
constexpr std::uint16_t kComment = 1, kApplication = 4, kName = 2, kResolution = 9, kFlags = 2;
constexpr std::size_t kHead = 8, kTail = 4, kPacketHead = 20;

template <class Number>
void put(std::string& out, Number number) {
  for (std::size_t i = 0; i < sizeof number; ++i)
    out += static_cast<char>(static_cast<std::make_unsigned_t<Number>>(number) >> (8 * i));
}

std::uint32_t u32_at(std::string_view in, std::size_t at) {
  std::uint32_t number = 0;
  for (std::size_t i = 4; i-- > 0;) number = number << 8 | static_cast<unsigned char>(in[at + i]);
  return number;
}

void pad(std::string& out) { out.resize((out.size() + 3) / 4 * 4); }

void put_option(std::string& out, std::uint16_t code, std::string_view value) {
  put(out, code);
  put(out, static_cast<std::uint16_t>(value.size()));
  out += value;
  pad(out);
}

std::string block(std::uint32_t type, std::string_view body) {
  const auto size = static_cast<std::uint32_t>(kHead + body.size() + kTail);
  std::string out;
  out.reserve(size);
  put(out, type);
  put(out, size);
  out += body;
  put(out, size);
  return out;
}

}  // namespace

std::string section_block(std::string_view application, std::string_view comment) {
  std::string body;
  put(body, kByteOrder);
  put(body, std::uint16_t{1});
  put(body, std::uint16_t{0});
  put(body, std::int64_t{-1});  // of any length
  put_option(body, kApplication, application);
  put_option(body, kComment, comment.substr(0, 1000));
  put_option(body, 0, {});
  return block(kSection, body);
}

std::string interface_block(std::string_view name, LinkType type) {
  std::string body;
  put(body, static_cast<std::uint32_t>(type));  // and two reserved bytes
  put(body, std::uint32_t{0});                  // packets of any length
  put_option(body, kName, name);
  put_option(body, kResolution, "\x09");
  put_option(body, 0, {});
  return block(kInterface, body);
}

std::string packet_block(const Packet& packet) {
  std::string body;
  body.reserve(kPacketHead + packet.bytes.size() + 16);
  const auto time = static_cast<std::uint64_t>(packet.utc_ns);
  const auto size = static_cast<std::uint32_t>(packet.bytes.size());
  put(body, packet.interface);
  put(body, static_cast<std::uint32_t>(time >> 32));
  put(body, static_cast<std::uint32_t>(time));
  put(body, size);  // recorded
  put(body, size);  // on the wire
  body += packet.bytes;
  pad(body);
  if (packet.direction != Direction::Unknown) {
    std::string flags;
    put(flags, static_cast<std::uint32_t>(packet.direction));
    put_option(body, kFlags, flags);
    put_option(body, 0, {});
  }
  return block(kEnhancedPacket, body);
}

bool is_pcapng(std::string_view bytes) {
  return bytes.size() >= kHead + 4 && u32_at(bytes, 0) == kSection && u32_at(bytes, kHead) == kByteOrder;
}

std::expected<std::optional<Packet>, std::string> PacketReader::next() {
  while (at_ < bytes_.size()) {
    const std::string_view rest = bytes_.substr(at_);
    const std::size_t size = rest.size() < kHead ? 0 : u32_at(rest, 4);
    if (size < kHead + kTail || size % 4 != 0 || size > rest.size() || u32_at(rest, size - kTail) != size)
      return std::unexpected("damaged, or cut off,");
    const std::uint32_t type = u32_at(rest, 0);
    const std::string_view body = rest.substr(kHead, size - kHead - kTail);
    if (type == kEnhancedPacket) {
      if (body.size() < kPacketHead || u32_at(body, 12) > body.size() - kPacketHead)
        return std::unexpected("damaged");
      const std::size_t length = u32_at(body, 12), options = kPacketHead + (length + 3) / 4 * 4;
      Packet packet{
          .interface = u32_at(body, 0),
          .utc_ns = static_cast<std::int64_t>(std::uint64_t{u32_at(body, 4)} << 32 | u32_at(body, 8)),
          .bytes = body.substr(kPacketHead, length)};
      // The flags are the first option that truepose writes.
      if (body.size() >= options + 8 && u32_at(body, options) == (std::uint32_t{4} << 16 | kFlags))
        packet.direction = static_cast<Direction>(u32_at(body, options + 4) & 3);
      at_ += size;
      return packet;
    }
    at_ += size;
  }
  return std::nullopt;
}

}  // namespace truepose::recording
