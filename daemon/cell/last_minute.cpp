#include "daemon/cell/last_minute.hpp"

#include <chrono>

namespace truepose::daemon {

using namespace std::chrono_literals;

void LastMinute::take(const StreamCounters& counters, drivers::TimePoint now) {
  if (!counts_.empty() && now - counts_.back().time < 1s) return;
  counts_.push_back({counters, now});
  while (now - counts_.front().time > 60s) counts_.pop_front();
}

StreamCounters LastMinute::of(const StreamCounters& now) const {
  if (counts_.empty()) return {};
  const StreamCounters& then = counts_.front().counters;
  StreamCounters since;
  since.answered = now.answered - then.answered;
  since.held = now.held - then.held;
  since.duplicate = now.duplicate - then.duplicate;
  since.late = now.late - then.late;
  since.late_by_daemon = now.late_by_daemon - then.late_by_daemon;
  since.late_by_machine = now.late_by_machine - then.late_by_machine;
  since.late_by_network = now.late_by_network - then.late_by_network;
  return since;
}

}  // namespace truepose::daemon
