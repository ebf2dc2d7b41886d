#include "daemon/replay/driver_replay.hpp"

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdint>
#include <limits>
#include <memory>

namespace truepose::daemon {

using namespace std::chrono_literals;
using recording::Kind;
using recording::Record;

namespace {

constexpr const char* kNotYetKnown = "made before the recording has the driver's state";
constexpr const char* kMissing = "made after records that are missing";
constexpr const char* kCancelled = "cancelled by who had made it";
constexpr const char* kUnended = "under way when the recording ends";
const std::string kUnreadable = "made after a record that cannot be read: ";
constexpr const char* kAfterDifference = "made after a difference, before the next connection";

/// By which the clock of a driver may have been late when it asked for the time. Where time ran out in the
/// very moment in which something came, one of them does as was done then.
constexpr std::array<drivers::Duration, 4> kLate{0us, 100us, 1ms, 10ms};

std::uint64_t number_of(const Record& record) {
  constexpr std::uint64_t kNone = std::numeric_limits<std::uint64_t>::max();
  if (record.kind == Kind::Outcome) {
    const auto outcome = read_outcome(record.bytes);
    return outcome ? outcome->call : kNone;
  }
  const auto call = read_call(record.bytes);
  return call ? call->number : kNone;
}

/// Where a replay can begin: how the driver stood is told, and no call is under way, which would end behind
/// that.
/// @return the number of records where there is no such place
std::size_t first_beginning(std::span<const Record> records) {
  std::uint64_t next_call = std::numeric_limits<std::uint64_t>::max(), first_ended = next_call;
  std::size_t found = records.size();
  for (std::size_t i = records.size(); i-- > 0;) {
    const Record& record = records[i];
    if (record.kind == Kind::Call) next_call = number_of(record);
    if (record.kind == Kind::Outcome) first_ended = std::min(first_ended, number_of(record));
    if (record.kind == Kind::Driver && first_ended >= next_call) found = i;
  }
  return found;
}

}  // namespace

void DriverReplay::miss() {
  replay_taken();
  records_.clear();
  why_not_yet_ = kMissing;
}

DriverReport DriverReplay::report() {
  replay_taken();
  return std::move(report_);
}

void DriverReplay::replay_taken() {
  std::string why = why_not_yet_.empty() ? kNotYetKnown : why_not_yet_;
  for (Records rest = records_; !rest.empty();) {
    const std::size_t begin = first_beginning(rest);
    pass_over(rest.first(begin), why);
    rest = rest.subspan(begin);
    if (!rest.empty()) rest = rest.subspan(replay_from(rest, why));
  }
}

/// @return how many records were dealt with
std::size_t DriverReplay::replay_from(Records records, std::string& why_next_is_not_judged) {
  const DriverScript script{records};
  if (script.steps().empty()) {
    why_next_is_not_judged = kUnreadable + script.unreadable();
    return 1;
  }
  std::unique_ptr<DriverRun> first;
  for (const drivers::Duration late : kLate) {
    auto run = std::make_unique<DriverRun>(script, late);
    run->run();
    const bool same = !run->difference();
    if (same || !first) first = std::move(run);
    if (same) break;
  }
  count(*first);
  if (first->difference()) {
    why_next_is_not_judged = kAfterDifference;
  } else if (!first->why_left().empty()) {
    why_next_is_not_judged = "not judged: " + first->why_left();
  } else if (!script.unreadable().empty()) {
    why_next_is_not_judged = kUnreadable + script.unreadable();
  }
  // At least the record that tells of the driver.
  return std::max<std::size_t>(first->end(), 1);
}

void DriverReplay::count(const DriverRun& run) {
  report_.calls += run.made();
  report_.same += run.same();
  const auto not_judged = [this](const std::string& why, std::uint64_t calls) {
    if (calls > 0) report_.not_judged[why] += calls;
  };
  std::uint64_t left = run.made() - run.same();
  if (run.difference()) {
    ++report_.different;
    left -= std::min<std::uint64_t>(left, 1);
    if (!report_.first_different) report_.first_different = run.difference();
  }
  const std::uint64_t cancelled = std::min(left, run.cancelled());
  const std::uint64_t unended = std::min(left - cancelled, run.unended());
  not_judged(kCancelled, cancelled);
  not_judged(kUnended, unended);
  not_judged(run.difference() ? kAfterDifference : run.why_left(), left - cancelled - unended);
}

void DriverReplay::pass_over(Records records, const std::string& why) {
  const auto calls = std::ranges::count(records, Kind::Call, &Record::kind);
  if (calls == 0) return;
  report_.calls += static_cast<std::uint64_t>(calls);
  report_.not_judged[why] += static_cast<std::uint64_t>(calls);
}

}  // namespace truepose::daemon
