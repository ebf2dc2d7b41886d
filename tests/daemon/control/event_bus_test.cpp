#include "daemon/control/event_bus.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <boost/json/object.hpp>
#include <boost/json/value.hpp>
#include <thread>

#include "proto/control/json_text.hpp"
#include "proto/control/request.hpp"

namespace truepose::daemon {
namespace {

using control::Topic;
using testing::ElementsAre;
using testing::IsEmpty;

const drivers::WallClock kEpoch = [] { return std::chrono::system_clock::time_point{}; };
const boost::json::object kNothing;

std::vector<std::uint64_t> numbers(const EventBus::Taken& taken) {
  std::vector<std::uint64_t> seqs;
  for (const auto& line : taken.lines)
    seqs.push_back(std::get<control::Event>(control::decode_server_line(*line).value()).seq);
  return seqs;
}

TEST(EventBus, NumbersEventsFromWhereTheLastRunEnded) {
  EventBus bus{{.first = 42, .end = 100'000, .request_more = {}}, kEpoch};
  const auto subscription = bus.subscribe({Topic::Cell, Topic::Log}, 0, [] {});
  for (const Topic topic : {Topic::Cell, Topic::Fault, Topic::Log}) bus.publish(topic, kNothing);
  EXPECT_THAT(numbers(subscription->take(10)), ElementsAre(42, 44));
  EXPECT_THAT(subscription->take(10).lines, IsEmpty());
  EXPECT_EQ(bus.next_seq(), 45U);
  EXPECT_EQ(bus.oldest_seq(), 42U);
}

TEST(EventBus, AsksOnceForMoreNumbersBeforeTheyRunOut) {
  int asked = 0;
  EventBus bus{{.first = 1, .end = 5'001, .request_more = [&] { ++asked; }}, kEpoch};
  const auto publish = [&](int count) {
    for (int i = 0; i < count; ++i) bus.publish(Topic::Log, kNothing);
  };
  publish(904);
  EXPECT_EQ(asked, 0);
  publish(1);
  EXPECT_EQ(asked, 1);
  publish(100);
  EXPECT_EQ(asked, 1);
  bus.extend(10'001);
  publish(100);
  EXPECT_EQ(asked, 1);
  publish(5'000);
  EXPECT_EQ(asked, 2);
}

TEST(EventBus, KeepsTheLastEventsForThoseWhoComeBack) {
  EventBus bus{{.first = 1, .end = 100'000, .request_more = {}}, kEpoch};
  for (std::size_t i = 0; i < EventBus::kKept + 10; ++i) bus.publish(Topic::Log, kNothing);
  EXPECT_EQ(bus.oldest_seq(), 11U);
  EXPECT_THAT(numbers(bus.subscribe({Topic::Log}, 3, [] {})->take(2)), ElementsAre(11, 12));
  EXPECT_THAT(numbers(bus.subscribe({Topic::Log}, 4104, [] {})->take(9)), ElementsAre(4105, 4106));
}

TEST(EventBus, GivesASlowReaderTheNewestOfWhatGoesOnAndEveryAlarm) {
  EventBus bus{{.first = 1, .end = 100'000, .request_more = {}}, kEpoch};
  const auto reader = bus.subscribe({Topic::Log, Topic::Fault}, 0, [] {});
  bus.publish(Topic::Fault, kNothing);
  for (std::size_t i = 0; i < EventBus::kBacklog + 10; ++i) bus.publish(Topic::Log, kNothing);
  bus.publish(Topic::Stream, kNothing);  // which it has not asked for
  const EventBus::Taken first = reader->take(2);
  EXPECT_THAT(numbers(first), ElementsAre(1, 13));
  EXPECT_THAT(first.dropped, ElementsAre(testing::Pair(Topic::Log, 11)));
  EXPECT_THAT(reader->take(2).dropped, IsEmpty()) << "reported once";
}

TEST(EventBus, DropsNothingOfWhatAClientThatComesBackAsksFor) {
  EventBus bus{{.first = 1, .end = 100'000, .request_more = {}}, kEpoch};
  for (std::size_t i = 0; i < EventBus::kKept; ++i) bus.publish(Topic::Log, kNothing);
  const auto reader = bus.subscribe({Topic::Log}, 0, [] {});
  const EventBus::Taken all = reader->take(EventBus::kKept);
  EXPECT_EQ(all.lines.size(), EventBus::kKept);
  EXPECT_THAT(all.dropped, IsEmpty());
}

TEST(EventBus, KeepsAlarmsForAReaderBeyondWhatIsKeptForAll) {
  EventBus bus{{.first = 1, .end = 100'000, .request_more = {}}, kEpoch};
  const auto reader = bus.subscribe({Topic::Log, Topic::Fault}, 0, [] {});
  for (const Topic topic : {Topic::Fault, Topic::Log, Topic::Fault}) bus.publish(topic, kNothing);
  for (std::size_t i = 0; i < EventBus::kKept + 5; ++i) bus.publish(Topic::Stream, kNothing);
  bus.publish(Topic::Fault, kNothing);
  const EventBus::Taken taken = reader->take(10);
  EXPECT_THAT(numbers(taken), ElementsAre(1, 3, 4105));
  EXPECT_THAT(taken.dropped, ElementsAre(testing::Pair(Topic::Log, 1)));
  EXPECT_FALSE(reader->fell_behind());
}

TEST(EventBus, TellsAReaderThatItFellBehindWhereTooManyAlarmsAreOwed) {
  EventBus bus{{.first = 1, .end = 100'000, .request_more = {}}, kEpoch};
  const auto fault_reader = bus.subscribe({Topic::Fault}, 0, [] {});
  const auto log_reader = bus.subscribe({Topic::Log}, 0, [] {});
  for (std::size_t i = 0; i < EventBus::kKept + EventBus::kMaxPending; ++i)
    bus.publish(Topic::Fault, kNothing);
  EXPECT_FALSE(fault_reader->fell_behind());
  bus.publish(Topic::Fault, kNothing);
  EXPECT_TRUE(fault_reader->fell_behind());
  EXPECT_FALSE(log_reader->fell_behind());
}

TEST(EventBus, TakesEventsFromSeveralThreads) {
  EventBus bus{{.first = 1, .end = 100'000, .request_more = {}}, kEpoch};
  std::atomic<int> woken = 0;
  const auto subscription = bus.subscribe({Topic::Fault}, 0, [&] { ++woken; });
  const auto publish = [&] {
    for (int i = 0; i < 500; ++i) bus.publish(Topic::Fault, kNothing);
  };
  std::thread first{publish};
  std::thread second{publish};
  first.join();
  second.join();
  const auto seqs = numbers(subscription->take(2000));
  ASSERT_EQ(seqs.size(), 1000U);
  for (std::size_t i = 0; i < seqs.size(); ++i) EXPECT_EQ(seqs[i], i + 1);
  EXPECT_EQ(woken, 1000);
}

TEST(Rfc3339, IsUtcWithMilliseconds) {
  using namespace std::chrono;
  EXPECT_EQ(control::rfc3339(sys_days{year{2026} / 11 / 21} + 10h + 4min + 5s + 67ms),
            "2026-11-21T10:04:05.067Z");
}

}  // namespace
}  // namespace truepose::daemon
