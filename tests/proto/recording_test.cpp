#include "proto/recording/recording.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <vector>

#include "core/math/random.hpp"
#include "proto/recording/block.hpp"
#include "proto/recording/difference.hpp"

namespace truepose::recording {
namespace {

using testing::HasSubstr;

constexpr std::uint64_t kSeed = 20'261'123;

std::string random_bytes(Random& random, std::size_t most, std::uint64_t letters) {
  std::string bytes(random.next() % (most + 1), '\0');
  for (char& byte : bytes) byte = static_cast<char>('.' + random.next() % letters);
  return bytes;
}

std::string difference(std::string_view before, std::string_view now) {
  std::string bytes;
  append_difference(bytes, before, now);
  return bytes;
}

TEST(ADifference, GivesBackAnyBytesFromAnyOthers) {
  SCOPED_TRACE("seed " + std::to_string(kSeed));
  Random random{kSeed};
  for (int i = 0; i < 20'000; ++i) {
    const std::uint64_t letters = i % 2 == 0 ? 4 : 256;  // few, so that much is alike
    const std::string before = random_bytes(random, 60, letters), now = random_bytes(random, 60, letters);
    ASSERT_EQ(apply_difference(before, difference(before, now), now.size()), now) << before << " to " << now;
  }
}

TEST(ADifference, OfFramesWithOtherNumbersIsMuchShorterThanTheyAre) {
  const std::string before =
      R"(<Rob Type="KUKA"><RIst X="1795.1234" Y="-12.5" Z="9.9999"/><IPOC>4208163</IPOC></Rob>)";
  const std::string now =
      R"(<Rob Type="KUKA"><RIst X="1795.1301" Y="-12.5" Z="10.0001"/><IPOC>4208167</IPOC></Rob>)";
  EXPECT_LT(difference(before, now).size(), 28U);
}

TEST(ADifference, ThatIsOfOtherBytesIsNotApplied) {
  const std::string made = difference("0123456789", "0123456789abc");
  EXPECT_TRUE(apply_difference("0123456789", made, 13));
  EXPECT_FALSE(apply_difference("0123", made, 13)) << "too little to take from";
  EXPECT_FALSE(apply_difference("0123456789", made, 12)) << "longer than may be";
  EXPECT_FALSE(apply_difference("0123456789", made.substr(0, made.size() - 1), 13)) << "cut off";
}

std::vector<Record> some_records() {
  const Peer peer{0x7f000001, 40'000};
  std::vector<Record> records{{.time_ns = -5, .kind = Kind::Started},
                              {.time_ns = 7'000'000'000, .kind = Kind::Commands, .bytes = "on 0 1"}};
  for (int i = 0; i < 20; ++i) {
    const std::string ipoc = "<IPOC>" + std::to_string(95 + i) + "</IPOC>";
    records.push_back({.time_ns = 7'000'000'000 + i, .peer = peer, .bytes = "<Rob>" + ipoc + "</Rob>"});
    records.push_back({.time_ns = 6'000'000'000 + i, .kind = Kind::Sent, .bytes = i % 3 == 0 ? "" : ipoc});
  }
  for (const auto& [name, wire] : kWires) {
    for (const auto& [what, kind] : kKinds) {
      if (wire != Wire::Rsi)
        records.push_back({.wire = wire, .kind = kind, .bytes = std::string{what} + '\0'});
    }
  }
  records.push_back({.time_ns = INT64_MAX, .peer = Peer{1, 2}, .bytes = std::string(kMostRecordBytes, 'x')});
  return records;
}

std::string block_of(const std::vector<Record>& records) {
  BlockWriter writer;
  for (const Record& record : records) EXPECT_TRUE(writer.append(record));
  return writer.bytes();
}

std::vector<Record> records_in(std::string_view block) {
  std::vector<Record> records;
  BlockReader reader{block};
  for (auto record = reader.next(); record && *record; record = reader.next()) records.push_back(**record);
  return records;
}

TEST(ABlock, GivesItsRecordsBack) { EXPECT_EQ(records_in(block_of(some_records())), some_records()); }

TEST(ABlock, ThatIsFullRefusesARecordAndKeepsWhatItHas) {
  BlockWriter writer;
  const Record large{.peer = Peer{1, 2}, .bytes = std::string(kMostRecordBytes, 'x')};
  const Record other{.bytes = std::string(kMostRecordBytes, 'y')};
  EXPECT_TRUE(writer.append(large)) << "an empty block has room";
  EXPECT_FALSE(writer.append(other));
  EXPECT_THAT(records_in(writer.bytes()), testing::ElementsAre(large));
  writer.clear();
  EXPECT_TRUE(writer.append(other)) << "nothing of the block before it is needed";
  EXPECT_THAT(records_in(writer.bytes()), testing::ElementsAre(other));
}

Header some_header() {
  return {.product = "0.1.0",
          .cell = "demo",
          .date = "2026-11-23T21:00:00.000Z",
          .time_ns = INT64_MAX,
          .reason = "E_CELL: the \"controller\" is silent",
          .robot = {"#KR210R2700_2 C4 FLR", "4711", "KSS 8.6.11"},
          .tracker = {"AT901", "390793", "3.8"},
          .ethernet_xml = "<ROOT>\n</ROOT>",
          .nominal_yaml = "name: arm\n",
          .stream = {{"max_step_rad", "0.0003490658503988659"}},
          .models = {{1, "id", "sha", "name: arm\n"}}};
}

std::string some_recording() {
  return first_block(some_header()) + block(block_of(some_records())) + block(block_of(some_records())) +
         last_block();
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
  EXPECT_EQ(first_block(*header), first_block(some_header()));
  const Read found = read(some_recording());
  EXPECT_EQ(found.damage, "");
  EXPECT_EQ(found.records.size(), 2 * some_records().size());
}

TEST(ARecordingFile, ThatIsCutOffAnywhereIsReadUpToThereAndSaysSo) {
  const std::string whole = some_recording();
  const std::size_t begin = first_block(some_header()).size(), one = block(block_of(some_records())).size();
  for (std::size_t size = begin; size < whole.size(); size += 997) {
    const Read found = read(whole.substr(0, size));
    EXPECT_THAT(found.damage, HasSubstr("cut off, at byte "));
    EXPECT_EQ(found.records.size(), (size - begin) / one * some_records().size()) << size;
  }
  EXPECT_THAT(read(whole.substr(0, begin - 1)).damage, HasSubstr("cut off, in its header"));
}

TEST(ARecordingFile, ThatIsDamagedIsReadUpToThere) {
  std::string damaged = some_recording();
  damaged[damaged.size() - 100] ^= 1;
  EXPECT_THAT(read(damaged).damage, HasSubstr("damaged"));
  EXPECT_EQ(read(damaged).records.size(), some_records().size());
}

TEST(ARecordingFile, OfTheVersionBeforeIsRead) {
  std::string before = some_recording();
  const std::string version = "truepose recording 2";
  ASSERT_TRUE(before.starts_with(version));
  before[version.size() - 1] = '1';
  EXPECT_EQ(read(before).damage, "");
  EXPECT_EQ(read(before).records, read(some_recording()).records);
}

TEST(ARecordingFile, OfAnotherKindIsRefused) {
  EXPECT_THAT(read("truepose recording 3\n").damage, HasSubstr("no recording"));
  EXPECT_THAT(read("").damage, HasSubstr("no recording"));
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
