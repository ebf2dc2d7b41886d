#include "daemon/control/event_bus.hpp"

#include <algorithm>
#include <boost/json/value.hpp>
#include <utility>

#include "proto/control/json_text.hpp"
#include "proto/control/request.hpp"

namespace truepose::daemon {

/// Numbers left when more are asked for: enough for the slowest disk.
constexpr std::uint64_t kLow = 4096;

namespace {

/// Whether a newer event of the topic makes up for an older one.
bool newest_wins(control::Topic topic) {
  using enum control::Topic;
  return topic == Stream || topic == Campaign || topic == Measurement || topic == Log;
}

}  // namespace

EventBus::EventBus(EventNumbers numbers, WallClock wall_clock)
    : numbers_{std::move(numbers)}, wall_clock_{std::move(wall_clock)}, next_{numbers_.first} {}

void EventBus::publish(control::Topic topic, const boost::json::value& data) {
  const std::lock_guard lock{mutex_};
  const std::uint64_t seq = next_++;
  if (next_ + kLow > numbers_.end && !std::exchange(asked_for_more_, true) && numbers_.request_more)
    numbers_.request_more();

  if (kept_.size() == kKept) {
    for (Subscription* subscription : subscriptions_)
      if (subscription->next_ <= seq - kKept)
        subscription->lose_oldest(kept_.front().topic, kept_.front().line);
    kept_.pop_front();
  }
  kept_.push_back({topic, std::make_shared<const std::string>(
                              control::encode_event(seq, control::rfc3339(wall_clock_()), topic, data))});
  for (const Subscription* subscription : subscriptions_)
    if (subscription->fell_behind_ || subscription->topics_.contains(topic)) subscription->wake_();
}

void EventBus::extend(std::uint64_t end) {
  const std::lock_guard lock{mutex_};
  numbers_.end = std::max(numbers_.end, end);
  asked_for_more_ = false;
}

std::uint64_t EventBus::next_seq() const {
  const std::lock_guard lock{mutex_};
  return next_;
}

std::uint64_t EventBus::oldest_seq() const {
  const std::lock_guard lock{mutex_};
  return oldest();
}

std::unique_ptr<EventBus::Subscription> EventBus::subscribe(std::set<control::Topic> topics,
                                                            std::uint64_t after, std::function<void()> wake) {
  const std::lock_guard lock{mutex_};
  const std::uint64_t first = std::clamp(after + 1, oldest(), next_);
  std::unique_ptr<Subscription> subscription{
      new Subscription{*this, std::move(topics), first, std::move(wake)}};
  subscriptions_.push_back(subscription.get());
  return subscription;
}

EventBus::Subscription::Subscription(EventBus& bus, std::set<control::Topic> topics, std::uint64_t next,
                                     std::function<void()> wake)
    : bus_{bus}, topics_{std::move(topics)}, next_{next}, live_from_{bus.next_}, wake_{std::move(wake)} {}

EventBus::Subscription::~Subscription() {
  const std::lock_guard lock{bus_.mutex_};
  bus_.subscriptions_.remove(this);
}

void EventBus::Subscription::lose_oldest(control::Topic topic, const Line& line) {
  next_ = bus_.oldest() + 1;
  if (!topics_.contains(topic)) return;
  if (newest_wins(topic)) {
    ++dropped_[topic];
  } else if (owed_.size() < kMostOwed) {
    owed_.push_back(line);
  } else {
    fell_behind_ = true;
  }
}

EventBus::Taken EventBus::Subscription::take(std::size_t count) {
  const std::lock_guard lock{bus_.mutex_};
  Taken taken;
  for (; !owed_.empty() && taken.lines.size() < count; owed_.pop_front())
    taken.lines.push_back(std::move(owed_.front()));
  for (; next_ < bus_.next_ && taken.lines.size() < count; ++next_) {
    const Kept& event = bus_.kept_[next_ - bus_.oldest()];
    if (!topics_.contains(event.topic)) continue;
    const bool too_old = next_ >= live_from_ && bus_.next_ - next_ > kBacklog;
    if (too_old && newest_wins(event.topic))
      ++dropped_[event.topic];
    else
      taken.lines.push_back(event.line);
  }
  if (!taken.lines.empty()) taken.dropped = std::exchange(dropped_, {});
  return taken;
}

bool EventBus::Subscription::fell_behind() const {
  const std::lock_guard lock{bus_.mutex_};
  return fell_behind_;
}

}  // namespace truepose::daemon
