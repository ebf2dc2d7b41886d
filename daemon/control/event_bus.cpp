#include "daemon/control/event_bus.hpp"

#include <algorithm>
#include <utility>

#include "core/planted_bug.hpp"
#include "proto/control/json_text.hpp"

namespace truepose::daemon {

namespace {

/// Numbers left when more are asked for: enough for the slowest disk.
constexpr std::uint64_t kLow = 4096;

/// Whether a newer event of the topic makes up for an older one.
bool newest_wins(control::Topic topic) {
  using enum control::Topic;
  return topic == Stream || topic == Campaign || topic == Measurement || topic == Log;
}

EventBus::Line line_of(const KeptEvent& event) {
  return std::make_shared<const std::string>(
      control::encode_event_text(event.seq, event.time, event.topic, event.data));
}

}  // namespace

EventBus::EventBus(EventNumbers numbers, drivers::WallClock wall_clock, EventArchive* archive)
    : numbers_{std::move(numbers)},
      wall_clock_{std::move(wall_clock)},
      archive_{archive},
      next_{numbers_.first},
      written_{next_ - 1} {}

void EventBus::publish(control::Topic topic, const boost::json::value& data, Keep keep) {
  const std::lock_guard lock{mutex_};
  if (kept_.size() == kKept) drop_oldest();
  const std::uint64_t seq = next_++;
  if (next_ + kLow > numbers_.end && !std::exchange(asked_for_more_, true) && numbers_.request_more)
    numbers_.request_more();

  KeptEvent event{seq, control::rfc3339(wall_clock_()), topic, control::json_text(data)};
  if (!planted("every hundredth event is dropped") || seq % 100 != 0)
    kept_.push_back({topic, line_of(event)});
  if (archive_ && keep == Keep::Lasting) leave_to_archive(std::move(event));
  for (const Subscription* subscription : subscriptions_)
    if (subscription->fell_behind_ || subscription->topics_.contains(topic)) subscription->wake_();
}

/// Makes room for the next event.
void EventBus::drop_oldest() {
  for (Subscription* subscription : subscriptions_)
    if (!subscription->catches_up_ && subscription->next_ <= oldest())
      subscription->lose_oldest(kept_.front().topic, kept_.front().line);
  kept_.pop_front();
}

void EventBus::leave_to_archive(KeptEvent event) {
  if (unwritten_.size() == kMostUnwritten) {
    const std::uint64_t seq = unwritten_.front().seq;
    unwritten_.pop_front();
    given_up_ = {given_up_ ? given_up_->first : seq, seq, "the store could not be written then"};
  }
  unwritten_.push_back(std::move(event));
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

EventBatch EventBus::unwritten(std::size_t count) const {
  const std::lock_guard lock{mutex_};
  EventBatch batch{.events = {}, .gaps = {}, .through = next_ - 1};
  if (given_up_) batch.gaps.push_back(*given_up_);
  const auto end = unwritten_.begin() + static_cast<std::ptrdiff_t>(std::min(count, unwritten_.size()));
  batch.events.assign(unwritten_.begin(), end);
  if (end != unwritten_.end()) batch.through = end->seq - 1;
  return batch;
}

void EventBus::written(const EventBatch& batch) {
  const std::lock_guard lock{mutex_};
  written_ = std::max(written_, batch.through);
  while (!unwritten_.empty() && unwritten_.front().seq <= batch.through) unwritten_.pop_front();
  if (given_up_ && given_up_->last <= batch.through) given_up_.reset();
}

std::unique_ptr<EventBus::Subscription> EventBus::subscribe(std::set<control::Topic> topics,
                                                            std::uint64_t after, std::function<void()> wake) {
  const std::lock_guard lock{mutex_};
  const std::uint64_t first = std::clamp(after + 1, archive_ ? 1 : oldest(), next_);
  std::unique_ptr<Subscription> subscription{
      new Subscription{*this, std::move(topics), first, std::move(wake)}};
  subscriptions_.push_back(subscription.get());
  return subscription;
}

EventBus::Subscription::Subscription(EventBus& bus, std::set<control::Topic> topics, std::uint64_t next,
                                     std::function<void()> wake)
    : bus_{bus},
      topics_{std::move(topics)},
      next_{next},
      live_from_{bus.next_},
      wake_{std::move(wake)},
      catches_up_{next < bus.oldest()} {}

EventBus::Subscription::~Subscription() {
  const std::lock_guard lock{bus_.mutex_};
  bus_.subscriptions_.remove(this);
}

void EventBus::Subscription::lose_oldest(control::Topic topic, const Line& line) {
  next_ = bus_.oldest() + 1;
  if (!topics_.contains(topic)) return;
  if (newest_wins(topic)) {
    ++dropped_[topic];
  } else if (pending_.size() < kMaxPending) {
    pending_.push_back(line);
  } else {
    fell_behind_ = true;
  }
}

std::optional<EventBus::Subscription::Missed> EventBus::Subscription::missed() const {
  const std::lock_guard lock{bus_.mutex_};
  return missed_locked();
}

std::optional<EventBus::Subscription::Missed> EventBus::Subscription::missed_locked() const {
  // What the archive does not have yet is still here.
  const std::uint64_t end = std::min(bus_.oldest(), bus_.written_ + 1);
  if (!catches_up_ || next_ >= end) return std::nullopt;
  return Missed{topics_, next_, end};
}

void EventBus::Subscription::resume_from(std::uint64_t next) {
  const std::lock_guard lock{bus_.mutex_};
  next_ = std::max(next_, next);
}

/// Those that neither the archive has nor the last events are.
void EventBus::Subscription::take_unwritten(std::size_t count, std::vector<Line>& lines) {
  auto event = std::ranges::lower_bound(bus_.unwritten_, next_, {}, &KeptEvent::seq);
  for (; event != bus_.unwritten_.end() && event->seq < bus_.oldest() && lines.size() < count; ++event) {
    if (topics_.contains(event->topic)) lines.push_back(line_of(*event));
    next_ = event->seq + 1;
  }
  if (lines.size() < count) next_ = std::max(next_, bus_.oldest());
}

EventBus::Taken EventBus::Subscription::take(std::size_t count) {
  const std::lock_guard lock{bus_.mutex_};
  Taken taken;
  if (missed_locked()) return taken;
  if (catches_up_) {
    take_unwritten(count, taken.lines);
    catches_up_ = next_ < bus_.oldest();
    if (catches_up_) return taken;
  }
  for (; !pending_.empty() && taken.lines.size() < count; pending_.pop_front())
    taken.lines.push_back(std::move(pending_.front()));
  for (next_ = std::max(next_, bus_.oldest()); next_ < bus_.next_ && taken.lines.size() < count; ++next_) {
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
