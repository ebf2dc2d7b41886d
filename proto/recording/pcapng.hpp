#pragma once

#include <cstdint>
#include <expected>
#include <optional>
#include <string>
#include <string_view>

/// Blocks of pcapng (draft-ietf-opsawg-pcapng), little-endian, times in ns: what Wireshark opens.
namespace truepose::recording {

enum class LinkType : std::uint16_t { Raw = 101, User0 = 147 };  ///< IPv4 packets; what only truepose reads
enum class Direction : std::uint8_t { Unknown, Inbound, Outbound };

/// The first block of a file.
std::string section_block(std::string_view application, std::string_view comment);
std::string interface_block(std::string_view name, LinkType type);

/// An enhanced packet block.
struct Packet {
  std::uint32_t interface = 0;  ///< the number of its interface block, from 0
  std::int64_t utc_ns = 0;
  Direction direction = Direction::Unknown;
  std::string_view bytes;
};
std::string packet_block(const Packet& packet);

/// Takes the packets out of a file, over other blocks.
class PacketReader {
 public:
  /// @param bytes  of a file, or of its beginning; outlive the reader
  explicit PacketReader(std::string_view bytes) : bytes_{bytes} {}
  /// The next packet; nothing at the end. Error: one phrase on what cannot be read.
  std::expected<std::optional<Packet>, std::string> next();
  /// The byte at which the next block begins.
  std::size_t at() const { return at_; }

 private:
  std::string_view bytes_;
  std::size_t at_ = 0;
};
bool is_pcapng(std::string_view bytes);

}  // namespace truepose::recording
