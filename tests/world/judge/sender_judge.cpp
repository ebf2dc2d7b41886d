#include "tests/world/judge/sender_judge.hpp"

#include <chrono>

namespace truepose::world {

void SenderJudge::see(const RsiCycle& cycle) {
  constexpr std::chrono::milliseconds kSilence{100};
  constexpr std::chrono::seconds kLongest{60};  // of a second sender, and of what it takes to change places
  const drivers::TimePoint now = log_.now();
  if (!cycle.is_second) {
    if (cycle.datagram.empty()) return;
    if (now - sent_ > kSilence) sends_since_ = now;
    sent_ = now;
    return;
  }
  if (cycle.session != second_) second_since_ = now;
  second_ = cycle.session;
  const bool is_first = cell_.pc.started() < sends_since_ && sends_since_ < second_since_;
  if (cycle.reply.empty() || !is_first || now - sent_ > kSilence) return;
  if (!log_.had_fault(
          {"rsi-cut", "rsi-corrupted", "rsi-silent", "rsi-dropped", "rsi-datagrams-lost", "rsi-restarted",
           "controller-restarted", "arm-exchanged", "pc-stalled", "pc-stalled-in-a-program"},
          kLongest))
    log_.broken("a second sender is answered");
}

}  // namespace truepose::world
