#include "daemon/recorder/ring.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include "config/text_file.hpp"
#include "daemon/recorder/recorder.hpp"
#include "daemon/recorder/recording_folder.hpp"
#include "drivers/mock/virtual_clock.hpp"
#include "tests/temp_folder.hpp"

namespace truepose::daemon {
namespace {

namespace fs = std::filesystem;
using testing::ElementsAre;
using testing::HasSubstr;

constexpr std::size_t kLarge = 60'000;

/// Of which a slot takes two.
void append_to(Ring& ring, std::int64_t number) {
  ring.append(number, std::string(kLarge, static_cast<char>('a' + number)));
}

/// The numbers of what it has.
std::vector<int> numbers_in(const Ring& ring) {
  std::vector<int> numbers;
  for (const Ring::Block& block : ring.blocks())
    for (std::size_t at = 0; at < block.texts.size(); at += kLarge) numbers.push_back(block.texts[at] - 'a');
  return numbers;
}

TEST(ARing, LetsTheOldestGiveWay) {
  const auto ring = Ring::in_process(Ring::kLeastBytes);  // room for seven blocks
  EXPECT_FALSE(ring->begin_ns());
  for (int number = 0; number < 17; ++number) append_to(*ring, number);
  ring->settle();
  EXPECT_THAT(numbers_in(*ring), ElementsAre(4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16));
  EXPECT_EQ(ring->begin_ns(), 4);
  EXPECT_NEAR(static_cast<double>(ring->bytes()), 13.0 * kLarge, 1000);
}

TEST(ARing, KeepsItsFileAsLargeAsItBegan) {
  const TempFolder folder;
  const auto ring = Ring::create(folder.path() / "ring", Ring::kLeastBytes);
  ASSERT_TRUE(ring) << ring.error();
  for (int number = 0; number < 17; ++number) append_to(**ring, number);
  EXPECT_EQ(fs::file_size(folder.path() / "ring"), Ring::kLeastBytes);
  const auto permissions = fs::status(folder.path() / "ring").permissions();
  EXPECT_EQ(permissions, fs::perms::owner_read | fs::perms::owner_write);
}

TEST(ARing, OfAProcessThatIsGoneIsReadUpToWhatWasSettled) {
  const TempFolder folder;
  {
    const auto ring = Ring::create(folder.path() / "ring", Ring::kLeastBytes);
    ASSERT_TRUE(ring) << ring.error();
    for (int number = 0; number < 5; ++number) append_to(**ring, number);
    (*ring)->settle();
    append_to(**ring, 5);  // behind, in the same slot
  }
  const auto left = Ring::open(folder.path() / "ring");
  ASSERT_TRUE(left) << left.error();
  EXPECT_THAT(numbers_in(**left), ElementsAre(0, 1, 2, 3, 4));
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
  const drivers::VirtualClock clock;
  auto ring = Ring::create(recordings.ring(), Ring::kLeastBytes);
  ASSERT_TRUE(ring) << ring.error();
  Recorder recorder{*std::move(ring), clock};
  ASSERT_TRUE(recorder.keep_header({.cell = "demo", .reason = "killed"}, recordings));
  EXPECT_EQ(save_left_behind(recordings, "now"), fs::path{}) << "it is empty";
  recorder.tell(recording::Wire::Tracker, recording::Kind::Received, "a packet");
  recorder.drain();
  const auto file = save_left_behind(recordings, "2026-11-23T21:00:00.000Z");
  ASSERT_TRUE(file) << file.error();
  EXPECT_EQ(file->filename(), "2026-11-23T21-00-00.000Z_1.pcapng");
  const auto recording = recording::Recording::read(config::read_bytes(*file));
  ASSERT_TRUE(recording) << recording.error();
  EXPECT_EQ(recording->header().reason, "killed");
  std::vector<std::string> texts;
  EXPECT_EQ(recording->for_each([&](const recording::Record& record) { texts.push_back(record.bytes); }), "");
  EXPECT_THAT(texts, ElementsAre("a packet"));
  remove_ring(recordings);
  EXPECT_EQ(save_left_behind(recordings, "later"), fs::path{}) << "who ends in order leaves none";
}

TEST(ARecordingFolder, GoesByTheOrderInWhichRecordingsWereMadeAndOldOnesWithoutANumberByTheirDates) {
  const TempFolder folder;
  const RecordingFolder recordings{{.folder = folder.path()}};
  for (const char* name : {"2026-12.pcapng", "2026-11.pcapng", "2026-03_9.pcapng", "2026-02_10.pcapng"})
    folder.write(name, "x");
  EXPECT_EQ(recordings.file("2026-01").filename(), "2026-01_11.pcapng");
  std::vector<std::string> names;
  for (const RecordingFolder::Entry& entry : recordings.list()) names.push_back(entry.name);
  EXPECT_THAT(names,
              ElementsAre("2026-02_10.pcapng", "2026-03_9.pcapng", "2026-12.pcapng", "2026-11.pcapng"));
}

TEST(ARecordingFolder, RemovesTheOldestAndKeepsTheNewestWhateverItsSize) {
  const TempFolder folder;
  const auto make = [&](const char* name, std::size_t bytes) { folder.write(name, std::string(bytes, 'x')); };
  make("2026-01.pcapng", 10);
  make("2026-02.pcapng", 10);
  make("2026-03.pcapng", 2 << 20);
  make("notes.txt", 10);
  EXPECT_THAT((RecordingFolder{{.folder = folder.path(), .max_files = 2, .max_mb = 9}}.prune()),
              ElementsAre("2026-01.pcapng"));
  const RecordingFolder small{{.folder = folder.path(), .max_files = 9, .max_mb = 1}};
  EXPECT_THAT(small.prune(), ElementsAre("2026-02.pcapng"));
  EXPECT_THAT(small.prune(), ElementsAre()) << "the newest stays";
  EXPECT_EQ(small.list().size(), 1U);
  EXPECT_TRUE(fs::exists(folder.path() / "notes.txt"));
  EXPECT_EQ(small.find("../" + folder.path().filename().string() + "/notes.txt"), fs::path{});
}

TEST(ARecordingFolder, RemovesWhatAKilledDaemonLeftUnfinished) {
  const TempFolder folder;
  const std::string ours = "2026-02.pcapng." + std::to_string(::getpid());
  for (const std::string& name : {std::string{"2026-01.pcapng"}, std::string{"2026-01.pcapng.4194305"}, ours,
                                  std::string{"notes.4194305"}, std::string{"2026-01.pcapng.old"}})
    folder.write(name, "x");
  const RecordingFolder recordings{{.folder = folder.path()}};
  EXPECT_THAT(recordings.remove_left_over(), ElementsAre("2026-01.pcapng.4194305"));
  EXPECT_THAT(recordings.remove_left_over(), ElementsAre());
  EXPECT_TRUE(fs::exists(folder.path() / ours)) << "which is being written";
}

}  // namespace
}  // namespace truepose::daemon
