#include "daemon/recorder/ring.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "config/text_file.hpp"
#include "daemon/recorder/recorder.hpp"
#include "daemon/recorder/recording_folder.hpp"
#include "tests/temp_folder.hpp"

namespace truepose::daemon {
namespace {

namespace fs = std::filesystem;
using recording::Record;
using testing::ElementsAre;
using testing::HasSubstr;

constexpr std::size_t kLarge = 60'000;

/// Of which a block takes two.
Record numbered(std::int64_t number) {
  return {.time_ns = number, .bytes = std::string(kLarge, static_cast<char>('a' + number))};
}

std::vector<std::int64_t> times_in(const Ring& ring) {
  std::vector<std::int64_t> times;
  for (const Ring::Block& block : ring.blocks()) {
    recording::BlockReader reader{block.records};
    for (auto record = reader.next(); record && *record; record = reader.next())
      times.push_back((*record)->time_ns);
  }
  return times;
}

TEST(ARing, LetsTheOldestGiveWay) {
  const auto ring = Ring::in_process(Ring::kLeastBytes);  // room for seven blocks
  EXPECT_FALSE(ring->begin_ns());
  for (int number = 0; number < 17; ++number) ring->append(numbered(number));
  ring->settle();
  EXPECT_THAT(times_in(*ring), ElementsAre(4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16));
  EXPECT_EQ(ring->begin_ns(), 4);
  EXPECT_NEAR(static_cast<double>(ring->bytes()), 13.0 * kLarge, 1000);
}

TEST(ARing, KeepsItsFileAsLargeAsItBegan) {
  const TempFolder folder;
  const auto ring = Ring::create(folder.path() / "ring", Ring::kLeastBytes);
  ASSERT_TRUE(ring) << ring.error();
  for (int number = 0; number < 17; ++number) (*ring)->append(numbered(number));
  EXPECT_EQ(fs::file_size(folder.path() / "ring"), Ring::kLeastBytes);
  const auto permissions = fs::status(folder.path() / "ring").permissions();
  EXPECT_EQ(permissions, fs::perms::owner_read | fs::perms::owner_write);
}

TEST(ARing, OfAProcessThatIsGoneIsReadUpToWhatWasSettled) {
  const TempFolder folder;
  {
    const auto ring = Ring::create(folder.path() / "ring", Ring::kLeastBytes);
    ASSERT_TRUE(ring) << ring.error();
    for (int number = 0; number < 5; ++number) (*ring)->append(numbered(number));
    (*ring)->settle();
    (*ring)->append(numbered(5));  // behind, in the same block
  }
  const auto left = Ring::open(folder.path() / "ring");
  ASSERT_TRUE(left) << left.error();
  EXPECT_THAT(times_in(**left), ElementsAre(0, 1, 2, 3, 4));
}

TEST(ARing, ThatCannotBeMadeSaysWhere) {
  const TempFolder folder;
  const auto ring = Ring::create(folder.path() / "none" / "ring", Ring::kLeastBytes);
  ASSERT_FALSE(ring);
  EXPECT_THAT(ring.error(), HasSubstr("none/ring: cannot be used for the recording: No such file"));
}

TEST(ARing, ThatAKilledProcessLeftBecomesARecordingAndOneThatIsEmptyDoesNot) {
  const TempFolder folder;
  const RecordingFolder recordings{{.folder = folder.path()}};
  EXPECT_EQ(save_left_behind(recordings, "now"), fs::path{}) << "there is none";
  const auto ring = Ring::create(recordings.ring(), Ring::kLeastBytes);
  ASSERT_TRUE(ring) << ring.error();
  ASSERT_TRUE(Recorder::keep_header({.cell = "demo", .reason = "killed"}, recordings));
  EXPECT_EQ(save_left_behind(recordings, "now"), fs::path{}) << "it is empty";
  (*ring)->append(numbered(1));
  (*ring)->settle();
  const auto file = save_left_behind(recordings, "2026-11-23T21:00:00.000Z");
  ASSERT_TRUE(file) << file.error();
  EXPECT_EQ(file->filename(), "2026-11-23T21-00-00.000Z_1.recording");
  const auto recording = recording::Recording::read(config::read_bytes(*file));
  ASSERT_TRUE(recording) << recording.error();
  EXPECT_EQ(recording->header().reason, "killed");
  std::vector<Record> records;
  EXPECT_EQ(recording->for_each([&](const Record& record) { records.push_back(record); }), "");
  EXPECT_THAT(records, ElementsAre(numbered(1)));
  remove_ring(recordings);
  EXPECT_EQ(save_left_behind(recordings, "later"), fs::path{}) << "who ends in order leaves none";
}

TEST(ARecordingFolder, GoesByTheOrderInWhichRecordingsWereMadeAndOldOnesWithoutANumberByTheirDates) {
  const TempFolder folder;
  const RecordingFolder recordings{{.folder = folder.path()}};
  for (const char* name :
       {"2026-12.recording", "2026-11.recording", "2026-03_9.recording", "2026-02_10.recording"})
    folder.write(name, "x");
  EXPECT_EQ(recordings.file("2026-01").filename(), "2026-01_11.recording");
  std::vector<std::string> names;
  for (const RecordingFolder::Entry& entry : recordings.list()) names.push_back(entry.name);
  EXPECT_THAT(names, ElementsAre("2026-02_10.recording", "2026-03_9.recording", "2026-12.recording",
                                 "2026-11.recording"));
}

TEST(ARecordingFolder, RemovesTheOldestAndKeepsTheNewestWhateverItsSize) {
  const TempFolder folder;
  const auto make = [&](const char* name, std::size_t bytes) { folder.write(name, std::string(bytes, 'x')); };
  make("2026-01.recording", 10);
  make("2026-02.recording", 10);
  make("2026-03.recording", 2 << 20);
  make("notes.txt", 10);
  EXPECT_THAT((RecordingFolder{{.folder = folder.path(), .max_files = 2, .max_mb = 9}}.prune()),
              ElementsAre("2026-01.recording"));
  const RecordingFolder small{{.folder = folder.path(), .max_files = 9, .max_mb = 1}};
  EXPECT_THAT(small.prune(), ElementsAre("2026-02.recording"));
  EXPECT_THAT(small.prune(), ElementsAre()) << "the newest stays";
  EXPECT_EQ(small.list().size(), 1U);
  EXPECT_TRUE(fs::exists(folder.path() / "notes.txt"));
  EXPECT_EQ(small.find("../" + folder.path().filename().string() + "/notes.txt"), fs::path{});
}

}  // namespace
}  // namespace truepose::daemon
