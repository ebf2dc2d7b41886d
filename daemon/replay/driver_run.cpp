#include "daemon/replay/driver_run.hpp"

#include <algorithm>
#include <boost/asio/bind_cancellation_slot.hpp>
#include <boost/asio/co_spawn.hpp>
#include <chrono>
#include <utility>

#include "daemon/replay/same_outcome.hpp"
#include "proto/recording/shown.hpp"

namespace truepose::daemon {

namespace asio = boost::asio;
using namespace std::chrono_literals;
using drivers::time_of;
using drivers::WireOperation;

namespace {

/// By which a timer may have been late when it was recorded.
constexpr drivers::Duration kTimersLate = 500ms;
/// In which what a driver does has been recorded.
constexpr drivers::Duration kRecorded = 100ms;

std::string said(recording::Kind kind, std::string_view bytes) {
  switch (kind) {
    case recording::Kind::Sent:
      return "sent " + recording::shown(bytes);
    case recording::Kind::Closed:
      return "the connection was closed";
    case recording::Kind::Air:
      return "asked for the air";
    default:
      return std::string{bytes};
  }
}

WireOperation operation_of(const recording::Record& record) {
  if (record.kind == recording::Kind::Connected) return WireOperation::Connect;
  if (record.kind == recording::Kind::Received) return WireOperation::Read;
  return drivers::read_failure(record.bytes)->operation;
}

}  // namespace

DriverRun::DriverRun(const DriverScript& script, drivers::Duration late)
    : script_{script}, clock_{time_of(script.steps().front().time_ns())}, late_{clock_, late} {
  for (const Wire wire : {Wire::EkiLink, Wire::EkiState, Wire::Tracker}) {
    const auto done = script_.done_by(wire);
    channels_[wire].expected.assign(done.begin(), done.end());
  }
  const auto air = script_.asks_for_air();
  air_.assign(air.begin(), air.end());
  const auto& steps = script_.steps();
  const auto first =
      std::ranges::find_if(steps, [](const auto& each) { return each.record->kind == Kind::Call; });
  auto driver = replayed_driver(
      *steps.front().record,
      {.executor = io_.get_executor(),
       .clock = late_,
       .tell = [this](Wire wire, Kind kind, std::string_view bytes) { hear(wire, kind, bytes); },
       .stream =
           [this](Wire wire) {
             Channel& channel = channels_[wire];
             auto stream = std::make_unique<ReplayedStream>([&channel] { return channel.write_fails; });
             channel.stream = stream.get();
             return stream;
           },
       .air = [this] { return tell_air(); },
       .calls = first == steps.end() ? 0 : first->call - 1});
  if (!driver) {
    why_left_ = driver.error();
    return;
  }
  driver_ = *std::move(driver);
}

/// What is under way has to end before the driver does.
DriverRun::~DriverRun() {
  if (!is_over()) why_left_ = "ended";
  for (const auto& [number, signal] : under_way_) signal->emit(asio::cancellation_type::terminal);
  settle();
  driver_.reset();
}

void DriverRun::settle() {
  io_.restart();
  io_.poll();
}

void DriverRun::run() {
  if (is_over()) return;
  come_to_next();
  while (step() && !is_over()) {
  }
  if (!is_over() && !owed_.empty()) miss_what_is_owed();
}

/// @return whether anything was left to do
bool DriverRun::step() {
  const DriverScript::Step* const next = next_done_to();
  const drivers::TimePoint time =
      next ? time_of(next->time_ns()) : time_of(script_.steps().back().time_ns()) + kTimersLate;
  const auto wake = clock_.next_wake();
  const bool timers_first = wake && *wake <= time &&
                            (!owed_.empty() || (next && (!is_awaited(*next) || *wake + kTimersLate <= time)));
  if (timers_first) {
    clock_.wake_first();
    settle();
    return true;
  }
  if (!next) return false;
  // What was recorded so long before this will not come any more.
  if (!owed_.empty() && time_of(script_.steps()[*owed_.begin()].time_ns()) + kTimersLate < time) {
    miss_what_is_owed();
    return false;
  }
  clock_.pass_to(time);
  do_next();
  settle();
  come_to_next();
  return true;
}

/// Passes over what the driver does, which it has done, or owes.
void DriverRun::come_to_next() {
  const auto& steps = script_.steps();
  for (; cursor_ < steps.size() && steps[cursor_].part != DriverScript::Part::DoneTo; ++cursor_)
    if (steps[cursor_].part == DriverScript::Part::DoneBy && early_.erase(cursor_) == 0)
      owed_.insert(cursor_);
}

const DriverScript::Step* DriverRun::next_done_to() const {
  return cursor_ < script_.steps().size() ? &script_.steps()[cursor_] : nullptr;
}

bool DriverRun::is_awaited(const DriverScript::Step& step) const {
  if (step.record->kind == Kind::Call || step.record->kind == Kind::Outcome) return true;
  const Channel& channel = channels_.at(step.record->wire);
  return channel.stream && channel.stream->awaits(operation_of(*step.record));
}

void DriverRun::do_next() {
  const DriverScript::Step& step = script_.steps()[cursor_];
  const recording::Record& record = *step.record;
  if (record.kind == Kind::Call || record.kind == Kind::Outcome) {
    record.kind == Kind::Call ? call(step) : cancel(step.call);
  } else if (ReplayedStream* const stream = channels_[record.wire].stream) {
    if (record.kind == Kind::Connected) stream->put_connected();
    if (record.kind == Kind::Received) stream->put_received(record.bytes);
    if (record.kind == Kind::Failed) stream->put_failure(*drivers::read_failure(record.bytes));
  }
  ++cursor_;
}

void DriverRun::call(const DriverScript::Step& step) {
  const bool owes_outcome = std::ranges::any_of(
      owed_, [this](std::size_t owed) { return script_.steps()[owed].record->kind == Kind::Outcome; });
  if (owes_outcome) return miss_what_is_owed();
  ++made_;
  DriverCall call = *read_call(step.record->bytes);
  if (!has_outcome(call.asked)) {
    driver_->make_at_once(call);
    if (!is_over()) ++same_;
    return;
  }
  if (!script_.outcome(step.call)) ++unended_;
  auto& signal = under_way_[step.call] = std::make_unique<asio::cancellation_signal>();
  auto made = driver_->make(std::move(call));
  asio::co_spawn(io_, std::move(made),
                 asio::bind_cancellation_slot(signal->slot(), [this, number = step.call](std::exception_ptr) {
                   under_way_.erase(number);
                 }));
}

void DriverRun::cancel(std::uint64_t number) {
  ++cancelled_;
  const auto call = under_way_.find(number);
  if (call != under_way_.end()) call->second->emit(asio::cancellation_type::terminal);
}

ToldAir DriverRun::tell_air() {
  if (air_.empty()) return std::unexpected("the recording has no more air readings");
  auto told = read_air(script_.steps()[air_.front()].record->bytes);
  if (!told) return std::unexpected(told.error());
  return *std::move(told);
}

void DriverRun::hear(Wire wire, Kind kind, std::string_view bytes) {
  if (is_over()) return;
  if (kind == Kind::Outcome) return hear_outcome(wire, bytes);
  if (kind == Kind::Air) return hear_done(air_, wire, kind, bytes);
  const auto found = channels_.find(wire);
  if (found == channels_.end()) return;
  Channel& channel = found->second;
  if (kind == Kind::Connected) channel.connected = true;
  const bool closed = kind == Kind::Closed && std::exchange(channel.connected, false);
  if (closed || kind == Kind::Sent) hear_done(channel.expected, wire, kind, bytes);
}

void DriverRun::hear_done(std::deque<std::size_t>& expected, Wire wire, Kind kind, std::string_view bytes) {
  if (expected.empty()) return surprise({}, wire, said(kind, bytes));
  const std::size_t step = expected.front();
  const recording::Record& then = *script_.steps()[step].record;
  if (then.kind != kind || then.bytes != bytes) return surprise(step, wire, said(kind, bytes));
  expected.pop_front();
  if (kind == Kind::Sent) channels_[wire].write_fails = script_.write_fails(step);
  mark(step);
}

/// How a cancelled call ends is no matter: it may just have been done.
void DriverRun::hear_outcome(Wire wire, std::string_view bytes) {
  const auto outcome = read_outcome(bytes);
  const auto step = outcome ? script_.outcome(outcome->call) : std::nullopt;
  if (!step || script_.is_cancelled(outcome->call)) return;
  if (!same_outcome(script_.steps()[*step].record->bytes, bytes))
    return differ(step, wire, std::string{bytes});
  ++same_;
  mark(*step);
}

void DriverRun::mark(std::size_t step) {
  if (owed_.erase(step) == 0) early_.insert(step);
}

/// The driver does what it did not do then. It may just have been cut off: by the end of the script, or by
/// who cancelled its call.
void DriverRun::surprise(std::optional<std::size_t> expected, Wire wire, const std::string& now) {
  const auto& steps = script_.steps();
  auto next = steps.begin() + static_cast<std::ptrdiff_t>(cursor_);
  next = std::find_if(next, steps.end(),
                      [](const auto& step) { return step.part == DriverScript::Part::DoneTo; });
  if (next == steps.end() && !expected) {
    why_left_ = "the recording ends";
  } else if (next != steps.end() && next->record->kind == Kind::Outcome &&
             time_of(next->time_ns()) <= clock_.now() + kRecorded) {
    why_left_ = "a call was cancelled at this moment";
  } else {
    differ(expected, wire, now);
  }
}

void DriverRun::differ(std::optional<std::size_t> expected, Wire wire, const std::string& now) {
  const auto& steps = script_.steps();
  const std::int64_t time_ns = expected ? steps[*expected].time_ns() : drivers::nanoseconds_of(clock_.now());
  const std::string then =
      expected ? said(steps[*expected].record->kind, steps[*expected].record->bytes) : "nothing";
  difference_ = {time_ns,
                 std::string{name_of(recording::kWires, wire)} + ": recorded: " + then + "; now: " + now};
}

void DriverRun::miss_what_is_owed() {
  const DriverScript::Step& owed = script_.steps()[*owed_.begin()];
  differ(*owed_.begin(), owed.record->wire, "nothing");
}

}  // namespace truepose::daemon
