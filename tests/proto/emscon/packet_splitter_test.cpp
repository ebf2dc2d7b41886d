#include "proto/emscon/packet_splitter.hpp"

#include <gtest/gtest.h>

#include "tests/proto/emscon/golden_packets.hpp"

namespace truepose::emscon {
namespace {

using Bytes = std::vector<std::uint8_t>;

std::vector<Bytes> drain(PacketSplitter& splitter) {
  std::vector<Bytes> packets;
  for (;;) {
    const auto packet = splitter.next();
    EXPECT_TRUE(packet);
    if (!packet || !*packet) return packets;
    packets.emplace_back((*packet)->begin(), (*packet)->end());
  }
}

struct Stream {
  std::vector<Bytes> packets;
  Bytes bytes;
};

Stream golden_stream() {
  Stream stream;
  for (const Golden& golden : golden_packets()) {
    stream.packets.push_back(bytes_of(golden.hex));
    stream.bytes.insert(stream.bytes.end(), stream.packets.back().begin(), stream.packets.back().end());
  }
  return stream;
}

TEST(PacketSplitter, CutsCoalescedPackets) {
  const Stream stream = golden_stream();
  PacketSplitter splitter;
  splitter.push(stream.bytes);
  EXPECT_EQ(drain(splitter), stream.packets);
}

TEST(PacketSplitter, JoinsPacketsSplitAtEveryPosition) {
  const Stream stream = golden_stream();
  for (std::size_t at = 0; at <= stream.bytes.size(); ++at) {
    PacketSplitter splitter;
    splitter.push(std::span{stream.bytes}.first(at));
    std::vector<Bytes> packets = drain(splitter);
    splitter.push(std::span{stream.bytes}.subspan(at));
    for (Bytes& packet : drain(splitter)) packets.push_back(std::move(packet));
    EXPECT_EQ(packets, stream.packets) << "split at " << at;
  }
}

TEST(PacketSplitter, JoinsPacketsFromSingleBytes) {
  const Stream stream = golden_stream();
  PacketSplitter splitter;
  std::vector<Bytes> packets;
  for (const std::uint8_t byte : stream.bytes) {
    splitter.push({&byte, 1});
    for (Bytes& packet : drain(splitter)) packets.push_back(std::move(packet));
  }
  EXPECT_EQ(packets, stream.packets);
}

TEST(PacketSplitter, RefusesASizeThatCannotBeAndGoesOnRefusing) {
  for (const std::string_view size : {"00000000", "07000000", "01000100", "ffffffff", "00000080"}) {
    PacketSplitter splitter;
    splitter.push(bytes_of(size));
    EXPECT_FALSE(splitter.next()) << size;
    splitter.push(bytes_of("0c000000 08000000 1b000000"));
    EXPECT_FALSE(splitter.next()) << size;
  }
}

TEST(PacketSplitter, AcceptsTheSmallestAndTheLargestPacket) {
  Bytes bytes = bytes_of("08000000 63000000 00000100");
  bytes.resize(8 + 64 * 1024);
  PacketSplitter splitter;
  splitter.push(bytes);
  const std::vector<Bytes> packets = drain(splitter);
  ASSERT_EQ(packets.size(), 2u);
  EXPECT_EQ(packets[0].size(), 8u);
  EXPECT_EQ(packets[1].size(), 64u * 1024);
}

}  // namespace
}  // namespace truepose::emscon
