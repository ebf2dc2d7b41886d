#include "daemon/replay/driver_script.hpp"

#include <cstdint>

#include "drivers/wire_failure.hpp"

namespace truepose::daemon {

using recording::Kind;
using recording::Record;
using recording::Wire;

DriverScript::DriverScript(std::span<const Record> records) {
  for (const Record& record : records) {
    unreadable_ = add(record);
    if (!unreadable_.empty()) return;
  }
}

/// @return why the record cannot be read
std::string DriverScript::add(const Record& record) {
  if (record.time_ns < 0 || record.time_ns > INT64_MAX / 4) return "a time that cannot be";
  Step step{.record = &record};
  switch (record.kind) {
    case Kind::Call:
      return add_call(step);
    case Kind::Outcome:
      return add_outcome(step);
    case Kind::Failed:
      if (const auto failure = drivers::read_failure(record.bytes); !failure) return failure.error();
      step.part = Part::DoneTo;
      break;
    case Kind::Connected:
      connected_.insert(record.wire);
      step.part = Part::DoneTo;
      break;
    case Kind::Received:
      step.part = Part::DoneTo;
      break;
    case Kind::Closed:
      // What was never connected is closed in passing.
      step.part = connected_.erase(record.wire) > 0 ? Part::DoneBy : Part::Neither;
      break;
    case Kind::Sent:
    case Kind::Air:
      step.part = Part::DoneBy;
      break;
    default:
      break;
  }
  steps_.push_back(step);
  return {};
}

std::string DriverScript::add_call(Step step) {
  const auto call = read_call(step.record->bytes);
  if (!call) return call.error();
  step.part = Part::DoneTo;
  step.call = call->number;
  begun_.insert(call->number);
  steps_.push_back(step);
  return {};
}

/// Of a call that was made before the script begins nothing is known.
std::string DriverScript::add_outcome(Step step) {
  const auto outcome = read_outcome(step.record->bytes);
  if (!outcome) return outcome.error();
  step.call = outcome->call;
  if (begun_.contains(step.call)) {
    step.part = outcome->cancelled ? Part::DoneTo : Part::DoneBy;
    if (outcome->cancelled) cancelled_.insert(step.call);
    outcomes_.emplace(step.call, steps_.size());
  }
  steps_.push_back(step);
  return {};
}

std::vector<std::size_t> DriverScript::done_by(Wire wire) const {
  std::vector<std::size_t> found;
  for (std::size_t i = 0; i < steps_.size(); ++i) {
    const Record& record = *steps_[i].record;
    const bool on_wire = record.kind == Kind::Sent || record.kind == Kind::Closed;
    if (steps_[i].part == Part::DoneBy && on_wire && record.wire == wire) found.push_back(i);
  }
  return found;
}

std::vector<std::size_t> DriverScript::asks_for_air() const {
  std::vector<std::size_t> found;
  for (std::size_t i = 0; i < steps_.size(); ++i)
    if (steps_[i].record->kind == Kind::Air) found.push_back(i);
  return found;
}

std::optional<std::size_t> DriverScript::outcome(std::uint64_t call) const {
  const auto found = outcomes_.find(call);
  return found == outcomes_.end() ? std::nullopt : std::optional{found->second};
}

bool DriverScript::write_fails(std::size_t sent) const {
  const Wire wire = steps_[sent].record->wire;
  for (std::size_t i = sent + 1; i < steps_.size(); ++i) {
    const Record& record = *steps_[i].record;
    if (record.wire != wire) continue;
    if (record.kind == Kind::Sent || record.kind == Kind::Closed || record.kind == Kind::Connected)
      return false;
    if (record.kind != Kind::Failed) continue;
    if (drivers::read_failure(record.bytes)->operation == drivers::WireOperation::Write) return true;
  }
  return false;
}

}  // namespace truepose::daemon
