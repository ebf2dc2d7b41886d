#include "tools/sim/controller/rsi_exchange.hpp"

#include <algorithm>
#include <utility>

namespace truepose::sim {
namespace {

using config::ScenarioFault;
using FaultKind = ScenarioFault::Kind;

}  // namespace

RsiExchange::RsiExchange(RsiWire& wire, RsiClient client, std::chrono::nanoseconds cycle,
                         std::vector<ScenarioFault> faults, std::uint64_t cycles_before)
    : wire_{wire},
      client_{std::move(client)},
      cycle_{cycle},
      faults_{std::move(faults)},
      cycles_before_{cycles_before} {}

// ---- What goes wrong in the cycle that comes ----

void RsiExchange::disturb(ScenarioFault fault) {
  fault.at = static_cast<std::int64_t>(coming_cycle());
  faults_.push_back(std::move(fault));
}

bool RsiExchange::begin_faults() {
  if (std::exchange(restarting_, false)) {
    held_back_.clear();
    late_.clear();
    wire_.restarted();
  }
  cycle_number_ = static_cast<std::int64_t>(coming_cycle());
  while (next_fault_ < faults_.size()) {
    const ScenarioFault& fault = faults_[next_fault_++];
    if (fault.begins_with(cycle_number_) && begin(fault)) return true;
  }
  next_fault_ = 0;
  client_.ignore_corrections(covers(FaultKind::RsiIgnore));
  return false;
}

/// @return whether the controller pauses before the cycle
bool RsiExchange::begin(const ScenarioFault& fault) {
  switch (fault.kind) {
    case FaultKind::RsiRestart:
      client_.restart(static_cast<std::uint64_t>(fault.lasts), fault.ipoc);
      restarting_ = true;
      [[fallthrough]];
    case FaultKind::RsiSilence:
      silent_cycles_ = fault.lasts;
      return true;
    case FaultKind::RsiIpoc:
      client_.jump_ipoc(fault.ipoc_by);
      return false;
    case FaultKind::RsiSecondSender:
      wire_.begin_second_sender(client_.twin(fault.ipoc_by), fault.from);
      return false;
    default:
      return false;
  }
}

bool RsiExchange::begin_silent_cycle() {
  if (silent_cycles_ <= 0 || !client_.is_on()) return false;
  --silent_cycles_;
  tick_ += cycle_;
  return true;
}

void RsiExchange::end_silent_cycle() {
  if (!restarting_) client_.pass();
}

bool RsiExchange::covers(FaultKind kind) const {
  return std::ranges::any_of(
      faults_, [&](const ScenarioFault& fault) { return fault.kind == kind && fault.covers(cycle_number_); });
}

// ---- The cycle ----

bool RsiExchange::begin_cycle() {
  datagram_ = client_.begin_cycle();
  if (datagram_.empty()) {
    end_ = RsiEnd::Off;
    return false;
  }
  tick_ += cycle_;
  return true;
}

void RsiExchange::send(Time now) {
  sent_[sent_count_++ % sent_.size()] = now;
  if (covers(FaultKind::RsiDrop) || covers(FaultKind::RsiLoseDatagrams)) return;
  if (!late_.empty()) wire_.send(std::exchange(late_, {}));
  if (covers(FaultKind::RsiLate)) {
    late_ = datagram_;
    return;
  }
  if (covers(FaultKind::RsiReorder) && held_back_.empty()) {
    held_back_ = datagram_;
    return;
  }
  wire_.send(covers(FaultKind::RsiCorrupt) ? garbled() : std::string{datagram_});
  if (covers(FaultKind::RsiDuplicate)) wire_.send(datagram_);
  if (!held_back_.empty()) wire_.send(std::exchange(held_back_, {}));
}

/// A place that changes from cycle to cycle, and a byte that no number and no name has.
std::string RsiExchange::garbled() const {
  constexpr std::size_t kFar = 31;
  std::string bytes{datagram_};
  bytes[static_cast<std::size_t>(cycle_number_) * kFar % bytes.size()] = '<';
  return bytes;
}

std::optional<std::chrono::nanoseconds> RsiExchange::receive(std::string_view reply, Time received) {
  if (covers(FaultKind::RsiDrop) || covers(FaultKind::RsiLoseReplies)) return std::nullopt;
  const RsiClient::Verdict verdict = client_.receive(reply);
  const bool timed = verdict.reply == RsiClient::Reply::Valid || verdict.reply == RsiClient::Reply::Late;
  if (!timed || verdict.cycles_ago >= sent_.size()) return std::nullopt;
  return received - sent_[(sent_count_ - 1 - verdict.cycles_ago) % sent_.size()];
}

}  // namespace truepose::sim
