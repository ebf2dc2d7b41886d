#include "daemon/control/event_bus.hpp"

#include <algorithm>
#include <boost/json/value.hpp>
#include <utility>

#include "proto/control/json_text.hpp"
#include "proto/control/request.hpp"

namespace truepose::daemon {

/// Numbers left when more are asked for: enough for the slowest disk.
constexpr std::uint64_t kLow = 4096;

EventBus::EventBus(EventNumbers numbers, WallClock wall_clock)
    : numbers_{std::move(numbers)}, wall_clock_{std::move(wall_clock)}, next_{numbers_.first} {}

void EventBus::publish(control::Topic topic, const boost::json::value& data) {
  const std::lock_guard lock{mutex_};
  const std::uint64_t seq = next_++;
  if (next_ + kLow > numbers_.end && !std::exchange(asked_for_more_, true) && numbers_.request_more)
    numbers_.request_more();

  if (kept_.size() == kKept) {
    for (Subscription* subscription : subscriptions_)
      if (subscription->next_ <= seq - kKept && subscription->topics_.contains(kept_.front().topic))
        subscription->fell_behind_ = true;
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
    : bus_{bus}, topics_{std::move(topics)}, next_{next}, wake_{std::move(wake)} {}

EventBus::Subscription::~Subscription() {
  const std::lock_guard lock{bus_.mutex_};
  bus_.subscriptions_.remove(this);
}

std::vector<EventBus::Line> EventBus::Subscription::take(std::size_t count) {
  const std::lock_guard lock{bus_.mutex_};
  std::vector<Line> lines;
  for (next_ = std::max(next_, bus_.oldest()); next_ < bus_.next_ && lines.size() < count; ++next_) {
    const Kept& event = bus_.kept_[next_ - bus_.oldest()];
    if (topics_.contains(event.topic)) lines.push_back(event.line);
  }
  return lines;
}

bool EventBus::Subscription::fell_behind() const {
  const std::lock_guard lock{bus_.mutex_};
  return fell_behind_;
}

}  // namespace truepose::daemon
