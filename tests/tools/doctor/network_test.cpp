#include "tools/truepose/doctor/network.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstddef>
#include <span>
#include <string>
#include <vector>

namespace truepose::tools {
namespace {

TEST(DroppingRules, AreThoseForWhatComesInUntilThePortIsLetIn) {
  const std::string nft =
      "table inet filter {\n"
      "  chain output {\n    type filter hook output priority 0; policy drop;\n  }\n"
      "  chain input {\n    type filter hook input priority 0; policy accept;\n    ip saddr 10.0.0.0/8 drop\n  }\n}\n";
  EXPECT_THAT(dropping_rules(nft, 49152), testing::ElementsAre("ip saddr 10.0.0.0/8 drop"));
  EXPECT_THAT(dropping_rules("-P INPUT DROP\n-A INPUT -i lo -j ACCEPT\n", 49152),
              testing::ElementsAre("-P INPUT DROP"));
  EXPECT_THAT(dropping_rules("-P INPUT DROP\n-A INPUT -p udp --dport 49152 -j ACCEPT\n", 49152),
              testing::IsEmpty());
  EXPECT_THAT(dropping_rules("", 49152), testing::IsEmpty());
}

TEST(ReadUdp, ReadsAPacketAndRefusesWhatIsNone) {
  const unsigned char packet[] = {0x45, 0,   0,  31, 0,    0,    0x40, 0,    64, 17, 0, 0, 192, 168, 44, 1,
                                  192,  168, 44, 10, 0xcb, 0x20, 0xc0, 0x00, 0,  11, 0, 0, 'R', 'o', 'b'};
  const auto bytes = std::as_bytes(std::span{packet});
  const auto udp = read_udp(bytes);
  ASSERT_TRUE(udp);
  EXPECT_EQ(udp->source, (drivers::UdpSource{0xc0a82c01, 52000}));
  EXPECT_EQ(udp->target, (drivers::UdpSource{0xc0a82c0a, 49152}));
  EXPECT_EQ(udp->payload, "Rob");
  for (std::size_t size = 0; size < 28; ++size) EXPECT_FALSE(read_udp(bytes.first(size))) << size;
  std::vector<std::byte> tcp{bytes.begin(), bytes.end()};
  tcp[9] = std::byte{6};
  EXPECT_FALSE(read_udp(tcp));
}

}  // namespace
}  // namespace truepose::tools
