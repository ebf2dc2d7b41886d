// Events in the store.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <stdexcept>
#include <string>

#include "daemon/store/store.hpp"
#include "tests/temp_folder.hpp"

namespace truepose::daemon {
namespace {

using control::Topic;
using testing::ElementsAre;
using testing::IsEmpty;

constexpr std::uint64_t kEnd = 1'000'000;
const std::set<Topic> kAll{Topic::Cell, Topic::Campaign, Topic::Measurement, Topic::Fault};

struct StoreEvents : testing::Test {
  Store open() {
    StoreResult<Store> store = Store::open(file);
    if (!store) throw std::runtime_error(store.error().detail);
    return std::move(*store);
  }
  static KeptEvent event(std::uint64_t seq, Topic topic = Topic::Fault,
                         const std::string& time = "2026-08-17T10:00:00.000Z") {
    return {seq, time, topic, R"({"text":")" + std::to_string(seq) + R"( \u00e4"})"};
  }
  static std::vector<std::uint64_t> numbers(Store& store, const std::set<Topic>& topics = kAll,
                                            std::uint64_t first = 1) {
    std::vector<std::uint64_t> seqs;
    for (EventPage page{.events = {}, .next = first}; page.next < kEnd;) {
      page = store.events(topics, page.next, kEnd).value();
      for (const KeptEvent& each : page.events) seqs.push_back(each.seq);
    }
    return seqs;
  }

  TempFolder folder;
  const std::filesystem::path file = folder.path() / "cell.db";
};

TEST_F(StoreEvents, AreGivenBackAsTheyWereInTheirOrderByTopic) {
  {
    Store store = open();
    ASSERT_EQ(store.begin_events(100).value(), 1U);
    ASSERT_TRUE(store.keep_events({{event(3), event(7, Topic::Cell)}, {}, 8}));
    ASSERT_TRUE(store.keep_events({{event(9)}, {}, 9}));
  }
  Store store = open();
  EXPECT_THAT(numbers(store), ElementsAre(3, 7, 9));
  EXPECT_THAT(numbers(store, {Topic::Fault}), ElementsAre(3, 9));
  EXPECT_THAT(numbers(store, kAll, 4), ElementsAre(7, 9));
  const EventPage page = store.events(kAll, 1, 8).value();
  EXPECT_THAT(page.events, ElementsAre(event(3), event(7, Topic::Cell)));
  EXPECT_EQ(page.next, 8U);
}

TEST_F(StoreEvents, ComeInPagesHoweverFewOfThemAreAskedFor) {
  Store store = open();
  ASSERT_TRUE(store.begin_events(10'000));
  EventBatch batch{.events = {}, .gaps = {}, .through = 2'000};
  for (std::uint64_t seq = 1; seq <= 2'000; ++seq)
    batch.events.push_back(event(seq, seq == 1'700 ? Topic::Cell : Topic::Fault));
  ASSERT_TRUE(store.keep_events(batch));
  EXPECT_EQ(numbers(store).size(), 2'000U);
  const EventPage first = store.events({Topic::Cell}, 1, kEnd).value();
  EXPECT_THAT(first.events, IsEmpty());
  EXPECT_LT(first.next, 1'700U) << "a point that is to be stored does not wait for the whole of it";
  EXPECT_THAT(numbers(store, {Topic::Cell}), ElementsAre(1'700));
}

TEST_F(StoreEvents, WhatADaemonThatWasKilledMayNotHaveKeptIsAGap) {
  {
    Store store = open();
    ASSERT_TRUE(store.begin_events(100));
    ASSERT_TRUE(store.keep_events({{event(5)}, {}, 20}));
  }
  Store store = open();
  EXPECT_EQ(store.begin_events(100).value(), 101U);
  const auto gaps = store.event_gaps(1, 200).value();
  ASSERT_EQ(gaps.size(), 1U);
  EXPECT_EQ(gaps.front().first, 21U);
  EXPECT_EQ(gaps.front().last, 100U);
  EXPECT_EQ(gaps.front().reason, "the daemon ended before they were on the disk");
  EXPECT_THAT(store.event_gaps(1, 21).value(), IsEmpty());
  EXPECT_EQ(store.event_gaps(50, 60).value().front(), (EventGap{50, 59, gaps.front().reason}));
}

TEST_F(StoreEvents, OlderThanWantedAreDroppedAndReportedAsAGapBeyondTheNewest) {
  Store store = open();
  constexpr std::uint64_t kFirst = 2'000, kNewest = 10'000;
  ASSERT_TRUE(store.begin_events(20'000));
  EventBatch batch{.events = {}, .gaps = {{1, 2, "lost"}}, .through = kFirst + kNewest - 1};
  std::vector<std::uint64_t> newest;
  for (std::uint64_t seq = 10; seq < 1'210; ++seq)
    batch.events.push_back(event(seq, Topic::Fault, "2026-05-01T00:00:00.000Z"));
  for (std::uint64_t seq = kFirst; seq < kFirst + kNewest; ++seq) {
    batch.events.push_back(event(seq, Topic::Fault, "2026-05-01T00:00:00.000Z"));
    newest.push_back(seq);
  }
  ASSERT_TRUE(store.keep_events(batch));
  const std::string before = "2026-05-10T00:00:00.000Z";
  EXPECT_TRUE(store.prune_events(before).value()) << "some at a time";
  while (store.prune_events(before).value()) {
  }
  EXPECT_EQ(numbers(store), newest) << "however old they are";
  const auto gaps = store.event_gaps(1, kEnd).value();
  ASSERT_EQ(gaps.size(), 1U);
  EXPECT_EQ(gaps.front(), (EventGap{1, 1'209, "older than is kept"}));
  EXPECT_FALSE(store.prune_events(before).value());
}

TEST_F(StoreEvents, ManyGapsAreReportedAsFewEnoughForALine) {
  Store store = open();
  ASSERT_TRUE(store.begin_events(10'000));
  EventBatch batch{.events = {}, .gaps = {}, .through = 5'000};
  for (std::uint64_t first = 1; first < 5'000; first += 10) batch.gaps.push_back({first, first + 1, "lost"});
  ASSERT_TRUE(store.keep_events(batch));
  const auto gaps = store.event_gaps(1, kEnd).value();
  EXPECT_LE(gaps.size(), 100U);
  EXPECT_EQ(gaps.front().first, 1U);
  for (std::size_t i = 1; i < gaps.size(); ++i) EXPECT_GT(gaps[i].first, gaps[i - 1].last);
  EXPECT_EQ(gaps.back().last, 4'992U);
}

TEST_F(StoreEvents, BeyondWhatWasReservedNeverRepeatANumber) {
  {
    Store store = open();
    ASSERT_TRUE(store.begin_events(10));
    ASSERT_TRUE(store.keep_events({{event(15)}, {}, 15}));
  }
  Store store = open();
  EXPECT_EQ(store.begin_events(10).value(), 16U);
}

}  // namespace
}  // namespace truepose::daemon
