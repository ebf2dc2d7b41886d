#pragma once

#include <cstdint>
#include <set>
#include <string>
#include <vector>

#include "daemon/store/store_error.hpp"
#include "proto/control/request.hpp"

namespace truepose::daemon {

/// An event as it is kept.
struct KeptEvent {
  std::uint64_t seq = 0;
  std::string time;  ///< RFC 3339
  control::Topic topic = control::Topic::Cell;
  std::string data;  ///< JSON, an object
  bool operator==(const KeptEvent&) const = default;
};

/// Numbers, the last included, of which events that should be kept may be missing. Not each of them need have
/// been given.
struct EventGap {
  std::uint64_t first = 1, last = 1;
  std::string reason;  ///< one phrase
  bool operator==(const EventGap&) const = default;
};

/// What is written at one time.
struct EventBatch {
  std::vector<KeptEvent> events;
  std::vector<EventGap> gaps;
  std::uint64_t through =
      0;  ///< with this batch every event up to here is kept, or in a gap, or not to be kept
};

/// A part of what is kept.
struct EventPage {
  std::vector<KeptEvent> events;
  std::uint64_t next = 0;  ///< number from which on to ask for what follows
};

/// Keeps events beyond a restart. Blocks; used by one thread.
class EventArchive {
 public:
  virtual ~EventArchive() = default;
  /// All of the batch, or nothing of it. An event that is there already stays.
  virtual StoreResult<void> keep_events(const EventBatch& batch) = 0;
  /// The next events of these topics, oldest first, of numbers from `first` to `end` - 1: as many as a thread
  /// with other work may read at a time.
  virtual StoreResult<EventPage> events(const std::set<control::Topic>& topics, std::uint64_t first,
                                        std::uint64_t end) = 0;
  /// Where something may be missing of the numbers from `first` to `end` - 1, in their order, few enough for
  /// a line of the protocol.
  virtual StoreResult<std::vector<EventGap>> event_gaps(std::uint64_t first, std::uint64_t end) = 0;
  /// Forgets some of the events from before a time (RFC 3339), and of those beyond what a disk should hold.
  /// @return whether there are more
  virtual StoreResult<bool> prune_events(const std::string& before) = 0;
};

}  // namespace truepose::daemon
