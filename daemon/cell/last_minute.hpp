#pragma once

#include <cstddef>
#include <deque>

#include "daemon/realtime/stream_status.hpp"
#include "drivers/clock.hpp"

namespace truepose::daemon {

/// What the stream counted within the last minute: a count since the start says nothing of today.
class LastMinute {
 public:
  /// Once in a while; takes no more than one count a second.
  void take(const StreamCounters& counters, drivers::TimePoint now);

  /// Since the oldest count of the last minute. @param now  as they are now
  StreamCounters of(const StreamCounters& now) const;

 private:
  struct Count {
    StreamCounters counters;
    drivers::TimePoint time;
  };
  std::deque<Count> counts_;
};

}  // namespace truepose::daemon
