#include "daemon/realtime/late_replies.hpp"

#include <chrono>

namespace truepose::daemon {
namespace {

// A reply sent so soon was in time, and datagrams so close together come out of a backlog.
constexpr std::chrono::milliseconds kInTime{1};

}  // namespace

std::optional<FoundFault> LateReplies::take(const ControllerSession::Hearing& hearing,
                                            drivers::TimePoint received) noexcept {
  const bool late = hearing.late > 0;
  began_ = late && !late_before_;
  late_before_ = late;
  const bool sent_in_time =
      hearing.elapsed == 1 && received_ && turnaround_ < kInTime && received - *received_ > kInTime;
  if (late) {
    rejected_ = sent_in_time ? rejected_ + 1 : 0;
  } else if (!hearing.missed) {
    rejected_ = 0;
  }
  if (late && rejected_ >= rejected_cycles_) return FoundFault{StreamFault::RepliesRejected, {}};
  return std::nullopt;
}

}  // namespace truepose::daemon
