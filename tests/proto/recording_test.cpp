#include "proto/recording/recording.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <vector>

namespace truepose::recording {
namespace {

using testing::HasSubstr;

std::vector<Record> some_records() {
  const Endpoint peer{0x7f000001, 40'000};
  std::vector<Record> records{{.time_ns = 5, .kind = Kind::Started},
                              {.time_ns = 7'000'000'000, .kind = Kind::Commands, .bytes = "on 0 1 1"}};
  for (int i = 0; i < 20; ++i) {
    const std::string ipoc = "<IPOC>" + std::to_string(95 + i) + "</IPOC>";
    records.push_back({.time_ns = 7'000'000'000 + i, .peer = peer, .bytes = "<Rob>" + ipoc + "</Rob>"});
    records.push_back({.time_ns = 6'000'000'000 + i, .kind = Kind::Sent, .bytes = i % 3 == 0 ? "" : ipoc});
  }
  for (const Wire wire : {Wire::EkiLink, Wire::EkiState, Wire::Tracker}) {
    records.push_back(
        {.wire = wire, .kind = Kind::Connected, .bytes = "192.168.0.2:40000 192.168.0.10:54600"});
    records.push_back({.wire = wire, .kind = Kind::Sent, .bytes = "<Cmd/>"});
    records.push_back({.wire = wire, .kind = Kind::Received, .bytes = std::string{"a \0 b", 5}});
    records.push_back({.wire = wire, .kind = Kind::Failed, .bytes = "read: Connection reset by peer"});
    records.push_back({.wire = wire, .kind = Kind::Closed});
  }
  records.push_back({.wire = Wire::Daemon, .kind = Kind::Fault, .bytes = "E_CELL: the controller is silent"});
  records.push_back({.wire = Wire::Daemon, .kind = Kind::Dropped, .bytes = "12"});
  records.push_back({.kind = Kind::Checkpoint, .bytes = std::string{"\0 \n", 3}});
  records.push_back(
      {.time_ns = INT64_MAX / 4, .peer = Endpoint{1, 2}, .bytes = std::string(kMostPayload, 'x')});
  return records;
}

Header some_header() {
  return {.product = "0.1.0",
          .cell = "demo",
          .date = "2026-11-23T21:00:00.000Z",
          .time_ns = 9'000'000'000,
          .clock_origin_ns = 1'795'000'000'000'000'000,
          .reason = "E_CELL: the \"controller\" is silent",
          .robot = {"#KR210R2700_2 C4 FLR", "4711", "KSS 8.6.11"},
          .tracker = {"AT901", "390793", "3.8"},
          .ethernet_xml = "<ROOT>\n</ROOT>",
          .nominal_yaml = "name: arm\n",
          .stream = {{"max_step_rad", "0.0003490658503988659"}},
          .models = {{1, "id", "sha", "name: arm\n"}}};
}

std::string some_recording() {
  RecordWriter writer{{0x7f000001, 49'152}, some_header().clock_origin_ns};
  std::string bytes = head(some_header(), 0);
  for (const Record& record : some_records()) bytes += writer.blocks(record);
  return bytes + tail(some_header());
}

struct Read {
  std::vector<Record> records;
  std::string damage;
};
Read read(const std::string& bytes) {
  Read found;
  const auto recording = Recording::read(bytes);
  found.damage = recording
                     ? recording->for_each([&](const Record& record) { found.records.push_back(record); })
                     : recording.error();
  return found;
}

TEST(ARecordingFile, GivesHeaderAndRecordsBack) {
  const auto header = Recording::read_header(some_recording());
  ASSERT_TRUE(header) << header.error();
  EXPECT_EQ(head(*header, 0), head(some_header(), 0));
  const Read found = read(some_recording());
  EXPECT_EQ(found.damage, "");
  EXPECT_EQ(found.records, some_records());
}

TEST(ARecordingFile, HasAHeaderOfAnySize) {
  Header header = some_header();
  header.nominal_yaml.assign(300'000, 'y');
  const auto found = Recording::read_header(head(header, 0));
  ASSERT_TRUE(found) << found.error();
  EXPECT_EQ(found->nominal_yaml, header.nominal_yaml);
}

TEST(ARecordingFile, ThatIsCutOffAnywhereIsReadUpToThereAndSaysSo) {
  const std::string whole = some_recording();
  const std::size_t begin = head(some_header(), 0).size();
  std::size_t most = 0;
  for (std::size_t size = begin; size < whole.size(); size += 97) {
    const Read found = read(whole.substr(0, size));
    EXPECT_THAT(found.damage, HasSubstr("cut off, at byte "));
    EXPECT_GE(found.records.size(), most);
    most = found.records.size();
  }
  EXPECT_GT(most, 40U);
  EXPECT_THAT(read(whole.substr(0, begin - 1)).damage, HasSubstr("cut off in its header"));
}

TEST(ARecordingFile, ThatIsDamagedIsReadUpToThere) {
  std::string damaged = some_recording();
  damaged[head(some_header(), 0).size() + 4] ^= 1;  // the size of the first record's block
  EXPECT_THAT(read(damaged).damage, HasSubstr("damaged"));
  EXPECT_EQ(read(damaged).records.size(), 0U);
}

TEST(ARecordingFile, OfAnotherKindIsRefused) {
  EXPECT_THAT(read("truepose recording 2\n").damage, HasSubstr("no recording"));
  EXPECT_THAT(read("").damage, HasSubstr("no recording"));
  EXPECT_THAT(read(section_block("Dumpcap", "") + interface_block("eth0", LinkType::Raw)).damage,
              HasSubstr("no recording"));
}

TEST(AnEndpoint, IsReadAgainAndAnotherAddressThanIPv4CountsAsUnknown) {
  EXPECT_EQ(text(*read_endpoint("192.168.0.20:7000")), "192.168.0.20:7000");
  EXPECT_EQ(text(*read_endpoint("[::1]:7000")), "0.0.0.0:7000");
  for (const char* wrong : {"", "192.168.0.20", "192.168.0.20:x", "192.168.0.20:70000"})
    EXPECT_FALSE(read_endpoint(wrong)) << wrong;
}

// What a receiver sums up is all ones (RFC 1071).
TEST(AnIpPacket, HasTheChecksumsOfTheNetwork) {
  const std::string bytes =
      bytes_of({.from = {0xc0a80002, 40'000}, .to = {0xc0a8000a, 49'152}, .payload = "<Rob/>"});
  const auto sum = [](std::string_view of) {
    const auto byte = [&](std::size_t at) {
      return at < of.size() ? static_cast<unsigned char>(of[at]) : 0U;
    };
    std::uint32_t total = 0;
    for (std::size_t i = 0; i < of.size(); i += 2) total += byte(i) * 256 + byte(i + 1);
    while (total >> 16) total = (total & 0xffff) + (total >> 16);
    return total;
  };
  EXPECT_EQ(sum(std::string_view{bytes}.substr(0, 20)), 0xffffU);
  const std::string pseudo_head = bytes.substr(12, 8) + std::string{"\0\x11\0\x0e", 4};
  EXPECT_EQ(sum(pseudo_head + bytes.substr(20)), 0xffffU);
}

TEST(Commands, AreTextThatIsReadAgain) {
  const Commands commands{Commands::Engagement::Armed, 3, 2, 1};
  EXPECT_EQ(text(commands), "armed 3 2 1");
  EXPECT_EQ(read_commands("armed 3 2 1"), commands);
  for (const char* wrong :
       {"", "armed", "armed 3 2", "armed 3 2 1 ", "armed x 2 1", "up 3 2 1", "armed  3 2 1"})
    EXPECT_FALSE(read_commands(wrong)) << wrong;
}

}  // namespace
}  // namespace truepose::recording
