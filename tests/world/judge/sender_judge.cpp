#include "tests/world/judge/sender_judge.hpp"

#include <chrono>

namespace truepose::world {

void SenderJudge::see(const RsiCycle& cycle) {
  constexpr std::chrono::seconds kLongest{60};  // of a second sender, and of what it takes to change places
  if (!cycle.is_second || cycle.reply.empty() || log_.now() - cell_.pc.started() < kLongest) return;
  if (!log_.had_fault({"rsi-cut", "rsi-corrupted", "rsi-silent", "rsi-dropped", "rsi-datagrams-lost",
                       "rsi-restarted", "controller-restarted", "arm-exchanged"},
                      kLongest))
    log_.broken("a second sender is answered");
}

}  // namespace truepose::world
