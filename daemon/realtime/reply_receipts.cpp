#include "daemon/realtime/reply_receipts.hpp"

#include <algorithm>
#include <utility>

namespace truepose::daemon {

ReplyReceipts::Verdict ReplyReceipts::read(std::optional<std::int64_t> delay,
                                           std::uint64_t elapsed) noexcept {
  cycles_ += static_cast<std::int64_t>(elapsed);
  Verdict verdict{.missed = replies_ > 0};
  if (!delay) return verdict;

  const std::optional<std::int64_t> before = std::exchange(before_, delay);
  const std::int64_t cycles = std::exchange(cycles_, 0), replies = std::exchange(replies_, 0);
  if (!before) return verdict;
  const std::int64_t rise = *delay - *before;
  // With one reply among the cycles, and it was taken: a sum has risen by the others, a count of those in a
  // row is at most the others. If it was not, a sum has risen by all of them, and the count is all of them at
  // least. With more replies a count of those in a row no longer tells which was taken.
  verdict.taken = replies == 1 && (rise == cycles - 1 || *delay <= cycles - 1);
  verdict.missed = replies > 0 && !verdict.taken;
  verdict.alive = cycles > 0 && rise >= cycles - replies;
  verdict.late = static_cast<std::uint64_t>(std::max<std::int64_t>(0, rise - (cycles - replies)));
  return verdict;
}

}  // namespace truepose::daemon
