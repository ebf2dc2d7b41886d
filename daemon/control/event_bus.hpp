#pragma once

#include <boost/json/value.hpp>
#include <chrono>
#include <cstdint>
#include <deque>
#include <functional>
#include <list>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "daemon/store/event_archive.hpp"
#include "drivers/clock.hpp"
#include "proto/control/request.hpp"
#include "proto/record/json_io.hpp"
#include "proto/rpc/method.hpp"

namespace truepose::daemon {

/// Where events get their numbers from, so that none repeats over restarts: a range that the store has
/// reserved.
struct EventNumbers {
  std::uint64_t first = 1;  ///< of the range
  std::uint64_t end = 1;    ///< one past its last
  /// Called when the range runs low, from the publishing thread: must not block (post to the store's thread),
  /// and leads to EventBus::extend(). Without an answer (disk full) the bus continues counting: a number that
  /// might repeat after a restart is a lesser evil than a fault that is never reported.
  std::function<void()> request_more;
};

/// Whether an event is kept beyond a restart.
enum class Keep {
  Lasting,
  Passing,  ///< superseded by the next of its kind: counters sent once a second, information in the log
};

/// Numbers, stamps and keeps the last events, and hands them to subscribers. Every call is thread-safe, and
/// none waits for a disk: what lasts is handed to an archive by an EventKeeper, and read from there again by
/// whoever serves a subscription.
class EventBus {
 public:
  using Line = std::shared_ptr<const std::string>;  ///< one encoded notification, newline included
  static constexpr std::size_t kKept = 4096;        ///< events kept for clients that come back
  /// Events that wait for an archive which takes none (a full disk) before the oldest are given up.
  static constexpr std::size_t kMostUnwritten = 16'384;

  /// @param archive  has what was published before; null: nothing is kept but what is kept here
  EventBus(EventNumbers numbers, drivers::WallClock wall_clock, EventArchive* archive = nullptr);

  /// Publishes from any thread. `data` is an object as openrpc.json describes it for the topic.
  void publish(control::Topic topic, const boost::json::value& data, Keep keep = Keep::Lasting);
  void publish(const rpc::Event auto& event, Keep keep = Keep::Lasting) {
    publish(event.kTopic, record::to_json(event), keep);
  }
  /// The store has reserved the numbers below `end` as well.
  void extend(std::uint64_t end);

  std::uint64_t next_seq() const;    ///< number of the event that will be published next
  std::uint64_t oldest_seq() const;  ///< number of the oldest event kept here; next_seq() if there is none

  EventArchive* archive() const { return archive_; }
  /// The first `count` events that the archive has not yet; nothing in it, and the number of what is kept,
  /// where there are none.
  EventBatch unwritten(std::size_t count) const;
  /// The archive has a batch.
  void written(const EventBatch& batch);

  /// Live events that a slow reader may be behind before it is given the newest alone.
  static constexpr std::size_t kBacklog = 256;
  /// Events that must not be dropped, kept for one slow reader beyond those that are kept for all.
  static constexpr std::size_t kMaxPending = 1024;

  /// What a reader gets.
  struct Taken {
    std::vector<Line> lines;   ///< oldest first
    control::Dropped dropped;  ///< that it did not get, lately; none without a line
  };

  /// A reader's place in the stream of events. A slow reader gets the newest event alone of a topic that
  /// reports progress (stream, campaign, measurement, log). An event that a user may have to act on is never
  /// dropped: a reader with too many of them in its queue is disconnected. A reader that reads the events
  /// that it missed from the archive loses none.
  class Subscription {
   public:
    /// What is to be read from the archive before there is anything to take.
    struct Missed {
      std::set<control::Topic> topics;
      std::uint64_t first, end;  ///< one past the last
    };

    ~Subscription();
    Subscription(const Subscription&) = delete;
    Subscription& operator=(const Subscription&) = delete;

    std::optional<Missed> missed() const;
    /// It was read up to there.
    void resume_from(std::uint64_t next);
    /// The next lines, at most `count`; none if there is nothing new, or something was missed.
    Taken take(std::size_t count);
    bool fell_behind() const;

   private:
    friend class EventBus;
    /// The oldest kept event goes, and was not taken.
    void lose_oldest(control::Topic topic, const Line& line);
    Subscription(EventBus& bus, std::set<control::Topic> topics, std::uint64_t next,
                 std::function<void()> wake);
    std::optional<Missed> missed_locked() const;
    void take_unwritten(std::size_t count, std::vector<Line>& lines);

    EventBus& bus_;
    std::set<control::Topic> topics_;
    std::uint64_t next_;       ///< number of the first event not taken
    std::uint64_t live_from_;  ///< what is older was there when it began, and is not dropped for slowness
    std::function<void()> wake_;
    std::deque<Line> pending_;  ///< older than all that is kept
    control::Dropped dropped_;
    bool catches_up_;  ///< it has not yet come to what is kept here
    bool fell_behind_ = false;
  };

  /// Subscribes to what follows event number `after` (0: all that is kept). `wake` is called when there is
  /// something to take, from any thread and with the bus locked: it must only post. The bus outlives its
  /// subscriptions.
  std::unique_ptr<Subscription> subscribe(std::set<control::Topic> topics, std::uint64_t after,
                                          std::function<void()> wake);

 private:
  struct Kept {
    control::Topic topic;
    Line line;
  };
  std::uint64_t oldest() const { return next_ - kept_.size(); }
  void drop_oldest();
  void leave_to_archive(KeptEvent event);

  mutable std::mutex mutex_;
  EventNumbers numbers_;
  drivers::WallClock wall_clock_;
  EventArchive* archive_;
  std::uint64_t next_;
  bool asked_for_more_ = false;
  std::deque<Kept> kept_;            ///< numbers oldest() to next_ - 1
  std::deque<KeptEvent> unwritten_;  ///< those that last and are not in the archive
  std::optional<EventGap> given_up_;
  std::uint64_t written_;  ///< up to this number the archive has all that lasts
  std::list<Subscription*> subscriptions_;
};

}  // namespace truepose::daemon
