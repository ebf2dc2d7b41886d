// Events over the lives of a daemon: bus, keeper and store together.
#include "daemon/control/event_keeper.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <boost/asio/bind_cancellation_slot.hpp>
#include <boost/asio/cancellation_signal.hpp>
#include <boost/asio/co_spawn.hpp>
#include <boost/asio/detached.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/json/object.hpp>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "daemon/store/store.hpp"
#include "drivers/mock/virtual_clock.hpp"
#include "proto/control/json_text.hpp"
#include "tests/temp_folder.hpp"

namespace truepose::daemon {
namespace {

namespace asio = boost::asio;
namespace json = boost::json;
using control::Topic;
using namespace std::chrono_literals;
using testing::ElementsAre;
using testing::IsEmpty;
using testing::SizeIs;

const std::set<Topic> kTopics{Topic::Cell, Topic::Fault, Topic::Stream, Topic::Log};

/// Does its jobs in place.
struct InPlace final : Worker {
  asio::awaitable<void> run(std::function<void()> job) override {
    job();
    co_return;
  }
};

/// An archive that can be set to accept nothing.
struct Stubborn final : EventArchive {
  explicit Stubborn(Store& kept) : store{kept} {}
  StoreResult<void> keep_events(const EventBatch& batch) override {
    ++writes;
    if (refuses) return std::unexpected(StoreError{"full", true});
    return store.keep_events(batch);
  }
  StoreResult<EventPage> events(const std::set<Topic>& topics, std::uint64_t first,
                                std::uint64_t end) override {
    return store.events(topics, first, end);
  }
  StoreResult<std::vector<EventGap>> event_gaps(std::uint64_t first, std::uint64_t end) override {
    return store.event_gaps(first, end);
  }
  StoreResult<bool> prune_events(const std::string& before) override { return store.prune_events(before); }

  Store& store;
  bool refuses = false;
  int writes = 0;
};

/// A daemon as far as its events go.
struct Life {
  explicit Life(const std::filesystem::path& file, std::chrono::system_clock::time_point since = {})
      : store{Store::open(file).value()}, wall_start{since} {
    asio::co_spawn(io, keeper.run(), asio::bind_cancellation_slot(stop.slot(), asio::detached));
  }
  ~Life() {
    stop.emit(asio::cancellation_type::terminal);
    pass(1ms);
  }
  void pass(drivers::Duration time) {
    bool over = false;
    asio::co_spawn(io, clock.sleep_until(clock.now() + time), [&](std::exception_ptr) { over = true; });
    clock.run(io, [&] { return over; });
  }
  void end_in_order() {
    const auto kept = store.end_events(events.unwritten(EventBus::kMostUnwritten));
    EXPECT_TRUE(kept);
  }
  void publish(int count, Topic topic = Topic::Cell, Keep keep = Keep::Lasting) {
    for (int i = 0; i < count; ++i) events.publish(topic, json::object{{"text", "\u00e4 line"}}, keep);
  }
  /// What a client gets that has seen `after`.
  std::vector<std::string> read(std::uint64_t after, const std::set<Topic>& topics = kTopics) {
    const auto reader = events.subscribe(topics, after, [] {});
    std::vector<std::string> lines;
    for (;;) {
      if (const auto missed = reader->missed()) {
        const EventPage page = archive.events(missed->topics, missed->first, missed->end).value();
        reader->resume_from(page.next);
        for (const KeptEvent& event : page.events)
          lines.push_back(control::encode_event_text(event.seq, event.time, event.topic, event.data));
        continue;
      }
      const std::vector<EventBus::Line> more = reader->take(64).lines;
      if (more.empty()) return lines;
      for (const EventBus::Line& line : more) lines.push_back(*line);
    }
  }

  Store store;
  Stubborn archive{store};
  std::chrono::system_clock::time_point wall_start;
  drivers::VirtualClock clock;
  asio::io_context io;
  drivers::WallClock wall_clock = [this] {
    return wall_start +
           std::chrono::duration_cast<std::chrono::system_clock::duration>(clock.now().time_since_epoch());
  };
  static constexpr std::uint64_t kNumbers = 100'000;
  std::uint64_t first = store.begin_events(kNumbers).value();
  EventBus events{{first, first + kNumbers, {}}, wall_clock, &archive};
  InPlace worker;
  std::vector<std::string> failures;
  EventKeeper keeper{{events, worker, clock, wall_clock,
                      [this](const StoreError& error) { failures.push_back(error.detail); }}};
  asio::cancellation_signal stop;
};

struct EventKeeperTest : testing::Test {
  static std::vector<std::uint64_t> numbers(const std::vector<std::string>& lines) {
    std::vector<std::uint64_t> seqs;
    for (const std::string& line : lines)
      seqs.push_back(std::get<control::Event>(control::decode_server_line(line).value()).seq);
    return seqs;
  }

  TempFolder folder;
  const std::filesystem::path file = folder.path() / "cell.db";
};

TEST_F(EventKeeperTest, AClientGetsWhatItMissedOverARestartInOrderWithoutGapOrRepeat) {
  std::vector<std::string> before_restart;
  {
    Life before{file};
    before.publish(6'000);
    before.pass(2s);
    before.publish(10, Topic::Fault);
    before_restart = before.read(5'000);
    ASSERT_THAT(before_restart, SizeIs(1'010));
    before.end_in_order();
  }
  Life after{file};
  EXPECT_THAT(after.store.event_gaps(5'001, after.first).value(), IsEmpty());
  after.publish(3, Topic::Fault);
  const std::vector<std::string> lines = after.read(5'000);
  ASSERT_THAT(lines, SizeIs(1'013));
  EXPECT_TRUE(std::equal(before_restart.begin(), before_restart.end(), lines.begin())) << "to the letter";
  EXPECT_THAT(numbers({lines.end() - 3, lines.end()}), ElementsAre(100'001, 100'002, 100'003));
  EXPECT_THAT(after.read(5'000, {Topic::Fault}), SizeIs(13));
}

TEST_F(EventKeeperTest, WhatPassesIsNotKept) {
  {
    Life before{file};
    before.publish(1, Topic::Stream, Keep::Passing);
    before.publish(1, Topic::Stream);
    before.publish(1, Topic::Log, Keep::Passing);
    EXPECT_THAT(before.read(0), SizeIs(3)) << "in the same life";
    before.end_in_order();
  }
  Life after{file};
  EXPECT_THAT(numbers(after.read(0)), ElementsAre(2));
}

TEST_F(EventKeeperTest, WhatADaemonThatWasKilledHadWrittenIsGivenAndTheRestIsReported) {
  {
    Life before{file};
    before.publish(5);
    before.pass(2s);
    before.publish(5);  // and killed before these are written
  }
  Life after{file};
  EXPECT_THAT(numbers(after.read(2)), ElementsAre(3, 4, 5));
  const auto gaps = after.store.event_gaps(3, after.first).value();
  ASSERT_THAT(gaps, SizeIs(1));
  EXPECT_EQ(gaps.front().first, 6U);
  EXPECT_EQ(gaps.front().last, 100'000U);
}

TEST_F(EventKeeperTest, AStoreThatTakesNothingCostsNoEventOfThoseWhoAreThereNorOfThoseWhoComeBack) {
  Life life{file};
  life.archive.refuses = true;
  const auto live = life.events.subscribe(kTopics, 0, [] {});
  std::size_t seen = 0;
  for (int i = 0; i < 100; ++i) {
    life.publish(100);
    life.pass(1s);
    for (auto lines = live->take(1000).lines; !lines.empty(); lines = live->take(1000).lines)
      seen += lines.size();
  }
  EXPECT_EQ(seen, 10'000U);
  EXPECT_FALSE(live->fell_behind());
  EXPECT_GT(life.failures.size(), 90U);
  EXPECT_THAT(life.read(0), SizeIs(10'000)) << "more than the last events";
  life.archive.refuses = false;
  life.pass(2s);
  EXPECT_THAT(life.events.unwritten(1).events, IsEmpty());
  EXPECT_THAT(life.read(0), SizeIs(10'000));
}

TEST_F(EventKeeperTest, WhatIsTooMuchToWaitForAStoreIsDroppedAndReported) {
  Life life{file};
  life.archive.refuses = true;
  constexpr int kLost = 100;
  life.publish(static_cast<int>(EventBus::kMostUnwritten) + kLost);
  life.archive.refuses = false;
  life.pass(2s);
  EXPECT_EQ(numbers(life.read(0)).front(), kLost + 1U);
  const auto gaps = life.store.event_gaps(1, life.events.oldest_seq()).value();
  ASSERT_THAT(gaps, SizeIs(1));
  EXPECT_EQ(gaps.front(), (EventGap{1, kLost, "the store could not be written then"}));
}

TEST_F(EventKeeperTest, AReaderThatCatchesUpIsNotTooSlowAndGetsWhatCameMeanwhile) {
  {
    Life before{file};
    before.publish(3'000);
    before.end_in_order();
  }
  Life life{file};
  const auto reader = life.events.subscribe(kTopics, 0, [] {});
  ASSERT_TRUE(reader->missed());
  life.publish(9'000);
  life.pass(2s);
  EXPECT_FALSE(reader->fell_behind());
  std::uint64_t seen = 0;
  for (auto missed = reader->missed(); missed; missed = reader->missed()) {
    const EventPage page = life.store.events(missed->topics, missed->first, missed->end).value();
    reader->resume_from(page.next);
    seen += page.events.size();
  }
  for (auto lines = reader->take(64).lines; !lines.empty(); lines = reader->take(64).lines)
    seen += lines.size();
  EXPECT_EQ(seen, 12'000U);
}

TEST_F(EventKeeperTest, EventsOfMoreThan90DaysAgoAreDroppedAndReported) {
  {
    Life before{file};
    before.publish(5);
    before.end_in_order();
  }
  constexpr int kNewest = 10'000;
  Life later{file, std::chrono::system_clock::time_point{} + std::chrono::days{89}};
  later.publish(kNewest);
  later.pass(2h);
  EXPECT_THAT(later.read(0), SizeIs(kNewest + 5));
  later.pass(24h);
  EXPECT_THAT(later.read(0), SizeIs(kNewest));
  const auto gaps = later.store.event_gaps(1, later.first).value();
  ASSERT_THAT(gaps, SizeIs(1));
  EXPECT_EQ(gaps.front(), (EventGap{1, 5, "older than is kept"}));
}

TEST_F(EventKeeperTest, AStartWithAClockThatIsFarAheadForgetsNothing) {
  {
    Life before{file};
    before.publish(500);
    before.end_in_order();
  }
  {
    Life ahead{file, std::chrono::system_clock::time_point{} + std::chrono::days{100}};
    ahead.pass(2h);
    ahead.end_in_order();
  }
  Life after{file};
  EXPECT_THAT(after.read(0), SizeIs(500));
  EXPECT_THAT(after.store.event_gaps(1, 500).value(), IsEmpty());
}

TEST_F(EventKeeperTest, AMillisecondOfEventsIsWrittenAtATime) {
  Life life{file};
  life.publish(1'000);
  life.pass(2s);
  EXPECT_EQ(life.archive.writes, 4);
}

}  // namespace
}  // namespace truepose::daemon
