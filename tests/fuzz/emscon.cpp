// Packets of the tracker. A stream gives the same ones however it is cut; what is accepted can be written and
// read.
#include <cstdint>
#include <span>
#include <type_traits>
#include <variant>
#include <vector>

#include "proto/emscon/packet_splitter.hpp"
#include "proto/emscon/packets.hpp"
#include "proto/emscon/status.hpp"
#include "tests/fuzz/pieces.hpp"
#include "tests/fuzz/target.hpp"

namespace truepose::fuzz {
namespace {

using Bytes = std::vector<std::uint8_t>;

/// The packets of a stream, up to the first error.
std::vector<Bytes> packets(const std::vector<std::string_view>& pieces) {
  emscon::PacketSplitter splitter;
  std::vector<Bytes> packets;
  for (const std::string_view piece : pieces) {
    splitter.push({reinterpret_cast<const std::uint8_t*>(piece.data()), piece.size()});
    while (true) {
      const auto packet = splitter.next();
      if (!packet) return packets;
      if (!*packet) break;
      packets.emplace_back((*packet)->begin(), (*packet)->end());
    }
  }
  return packets;
}

/// Whether a stream begins with a whole packet: its size comes first, in little-endian bytes.
bool begins_with_packet(std::string_view stream) {
  if (stream.size() < 4) return false;
  std::uint64_t size = 0;
  for (std::size_t i = 4; i-- > 0;) size = size << 8 | static_cast<unsigned char>(stream[i]);
  return size >= emscon::PacketSplitter::kHeadSize && size <= emscon::PacketSplitter::kMaxPacketSize &&
         size <= stream.size();
}

/// Nothing for a packet that we have no use for.
template <typename Packet>
Bytes encoded(const Packet& packet) {
  return std::visit(
      [](const auto& kind) {
        if constexpr (std::is_same_v<std::decay_t<decltype(kind)>, emscon::Unknown>) {
          return Bytes{};
        } else {
          return emscon::encode(kind);
        }
      },
      packet);
}

/// Compares bytes, not values: a NaN is not even itself.
template <typename Decode>
void expect_round_trip(const Bytes& packet, Decode decode) {
  const auto meaning = decode(packet);
  if (!meaning) {
    expect(!meaning.error().what.empty() && meaning.error().offset <= packet.size(), "a fault says where");
    return;
  }
  const Bytes written = encoded(*meaning);
  if (written.empty()) return;
  expect(written.size() <= packet.size(), "nothing is read that is not there");
  const auto again = decode(written);
  expect(again && encoded(*again) == written, "what is written is read again");
}

}  // namespace

void emscon(std::string_view input) {
  const std::vector<Bytes> whole = packets({input});
  expect(packets(pieces_of(input)) == whole && packets(bytes_of(input)) == whole,
         "a stream gives the same packets however it is cut");
  for (const Bytes& packet : whole) {
    expect(begins_with_packet(input), "what is no packet is not handed out");
    input.remove_prefix(packet.size());
    expect_round_trip(packet, emscon::decode_tracker_packet);
    expect_round_trip(packet, emscon::decode_client_packet);
  }
  expect(!begins_with_packet(input), "every whole packet is handed out");
}

}  // namespace truepose::fuzz
