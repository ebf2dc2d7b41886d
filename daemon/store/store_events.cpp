#include <algorithm>
#include <array>
#include <string_view>
#include <utility>

#include "daemon/store/store_impl.hpp"

namespace truepose::daemon {

using sqlite::in;
using sqlite::Statement;

namespace {

// So many are read or forgotten in a millisecond or two: a point that is to be stored waits no longer.
constexpr int kAtATime = 500;
// Kept however old they are, since a clock may be wrong: about what a cell makes in 90 days.
constexpr int kFewestEvents = 10'000;
// Half a gigabyte; a cell makes a hundredth of it in 90 days, unless something comes and goes all the time.
constexpr int kMostEvents = 1'000'000;
// Of a line of the protocol.
constexpr std::size_t kMostGaps = 100;

std::int64_t stored(std::uint64_t number) { return static_cast<std::int64_t>(number); }
std::uint64_t number_of(std::int64_t stored) { return static_cast<std::uint64_t>(stored); }

/// Condition of the events before the so many newest.
std::string beyond_newest(int count) {
  return "seq<(SELECT seq FROM event ORDER BY seq DESC LIMIT 1 OFFSET " + std::to_string(count - 1) + ")";
}

/// Makes one of the first ones, so that no more than kMostGaps are left.
void join_first(std::vector<EventGap>& gaps) {
  if (gaps.size() <= kMostGaps) return;
  const std::size_t last = gaps.size() - kMostGaps;
  gaps.front().last = gaps[last].last;
  gaps.front().reason = "for several reasons, or in parts";
  gaps.erase(gaps.begin() + 1, gaps.begin() + static_cast<std::ptrdiff_t>(last) + 1);
}

}  // namespace

StoreResult<std::uint64_t> Store::begin_events(std::uint64_t count) {
  auto& database = *impl_->database;
  Statement lost = database.prepare(
      "INSERT OR REPLACE INTO event_gap SELECT kept+1, last, 'the daemon ended before they were on the disk' "
      "FROM event_number WHERE kept<last");
  Statement all_kept = database.prepare("UPDATE event_number SET kept=last");
  Statement add = database.prepare("UPDATE event_number SET last=last+?");
  add.bind(stored(count));
  const StoreResult<void> begun = impl_->commit("beginning to keep events", {&lost, &all_kept, &add});
  if (!begun) return std::unexpected(begun.error());
  return first_reserved(count);
}

StoreResult<std::uint64_t> Store::reserve_event_numbers(std::uint64_t count) {
  Statement add = impl_->database->prepare("UPDATE event_number SET last=last+?");
  add.bind(stored(count));
  const StoreResult<void> reserved = impl_->commit("reserving event numbers", {&add});
  if (!reserved) return std::unexpected(reserved.error());
  return first_reserved(count);
}

StoreResult<std::uint64_t> Store::first_reserved(std::uint64_t count) {
  const StoreResult<std::uint64_t> last = last_event_number();
  if (!last) return last;
  return *last - count + 1;
}

StoreResult<void> Store::keep_events(const EventBatch& batch) {
  // Where the store could not reserve more in time, events continued beyond what was reserved.
  return keep_events(batch, "UPDATE event_number SET kept=max(kept,?1), last=max(last,?1)");
}

StoreResult<void> Store::end_events(const EventBatch& batch) {
  // The numbers that are left were never given.
  return keep_events(batch, "UPDATE event_number SET kept=max(last,?1), last=max(last,?1)");
}

/// @param mark  says what is kept, by the last number of the batch
StoreResult<void> Store::keep_events(const EventBatch& batch, std::string_view mark) {
  std::vector<Statement> statements;
  for (const EventGap& gap : batch.gaps) {
    statements.push_back(impl_->database->prepare("INSERT OR REPLACE INTO event_gap VALUES (?,?,?)"));
    statements.back().bind(stored(gap.first)).bind(stored(gap.last)).bind(gap.reason);
  }
  for (const KeptEvent& event : batch.events) {
    statements.push_back(impl_->database->prepare("INSERT OR IGNORE INTO event VALUES (?,?,?,?)"));
    statements.back()
        .bind(stored(event.seq))
        .bind(event.time)
        .bind(control::name(event.topic))
        .bind(event.data);
  }
  statements.push_back(impl_->database->prepare(mark));
  statements.back().bind(stored(batch.through));
  std::vector<Statement*> all;
  for (Statement& statement : statements) all.push_back(&statement);
  return impl_->commit("keeping events", all);
}

StoreResult<EventPage> Store::events(const std::set<control::Topic>& topics, std::uint64_t first,
                                     std::uint64_t end) {
  Statement query = impl_->database->prepare(
      "SELECT seq, time, topic, data FROM event WHERE seq>=? AND seq<? ORDER BY seq LIMIT ?");
  query.bind(stored(first)).bind(stored(end)).bind(std::int64_t{kAtATime});
  EventPage page{.events = {}, .next = end};
  for (int rows = 0;; ++rows) {
    const StoreResult<bool> row = query.step();
    if (!row) return std::unexpected(in("reading events", row.error()));
    if (!*row) return page;
    const std::uint64_t seq = number_of(query.integer(0));
    const auto topic = control::topic_from_name(query.text(2));
    if (topic && topics.contains(*topic)) page.events.push_back({seq, query.text(1), *topic, query.text(3)});
    if (rows + 1 == kAtATime) page.next = seq + 1;
  }
}

StoreResult<std::vector<EventGap>> Store::event_gaps(std::uint64_t first, std::uint64_t end) {
  Statement query = impl_->database->prepare(
      "SELECT first, last, reason FROM event_gap WHERE last>=?1 AND first<?2 ORDER BY first");
  query.bind(stored(first)).bind(stored(end));
  std::vector<EventGap> gaps;
  for (;;) {
    const StoreResult<bool> row = query.step();
    if (!row) return std::unexpected(in("reading which events are missing", row.error()));
    if (!*row) break;
    gaps.push_back({std::max(number_of(query.integer(0)), first),
                    std::min(number_of(query.integer(1)), end - 1), query.text(2)});
  }
  join_first(gaps);
  return gaps;
}

StoreResult<bool> Store::prune_events(const std::string& before) {
  const std::string at_a_time = " LIMIT " + std::to_string(kAtATime);
  // Each by an index of its own.
  StoreResult<bool> more =
      forget_events("time<?1 AND " + beyond_newest(kFewestEvents) + " ORDER BY time" + at_a_time, before);
  if (!more || *more) return more;
  return forget_events(beyond_newest(kMostEvents) + " AND ?1<>'' ORDER BY seq" + at_a_time, before);
}

/// @param which  condition of those to forget, with the time `before` as its first value
/// @return whether there may be more
StoreResult<bool> Store::forget_events(const std::string& which, const std::string& before) {
  constexpr std::string_view kOperation = "forgetting old events";
  const std::string chosen = "SELECT seq FROM event WHERE " + which;
  Statement gap = impl_->database->prepare(
      "INSERT OR REPLACE INTO event_gap SELECT 1, max(seq), 'older than is kept' FROM (" + chosen +
      ") HAVING count(*)>0");
  gap.bind(before);
  Statement joined = impl_->database->prepare(
      "DELETE FROM event_gap WHERE first>1 AND last<=(SELECT last FROM event_gap WHERE first=1)");
  Statement forget = impl_->database->prepare("DELETE FROM event WHERE seq IN (" + chosen + ")");
  forget.bind(before);
  const StoreResult<void> forgotten = impl_->commit(kOperation, {&gap, &joined, &forget});
  if (!forgotten) return std::unexpected(forgotten.error());
  return impl_->database->changes() == kAtATime;
}

}  // namespace truepose::daemon
