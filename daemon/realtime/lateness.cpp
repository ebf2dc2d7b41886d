#include "daemon/realtime/lateness.hpp"

#include <algorithm>

namespace truepose::daemon {

using drivers::Duration;

void Lateness::heard(drivers::TimePoint received, std::uint64_t elapsed) noexcept {
  const Duration since = (cycle_ + cycle_ / kDrift) * static_cast<Duration::rep>(elapsed);
  due_ = due_ ? std::min(received, *due_ + since) : received;
  const Duration behind = received - *due_;
  if (behind <= cycle_ / 2) {
    behind_ = 0;
    return;
  }
  least_behind_ = behind_ == 0 ? behind : std::min(least_behind_, behind);
  if (++behind_ <= kUsual) return;
  *due_ += least_behind_;
  behind_ = 0;
}

std::optional<LateBy> Lateness::judge(const drivers::CycleTimes& times) noexcept {
  const Duration network = times.received - due_.value_or(times.received);
  const Duration waited = std::max(Duration{0}, busy_until_ - times.received);
  // What the thread was not running for, it was kept from.
  const Duration us = std::min(times.ready - times.taken, times.ran);
  const Duration machine = times.sent - times.received - waited - us;
  busy_until_ = times.sent;
  const Duration greatest = std::max({network, waited, us, machine});
  if (greatest != waited) {
    held_up_ = greatest == us ? LateBy::Daemon : greatest == machine ? LateBy::Machine : LateBy::Network;
  }
  const bool late = network + (times.sent - times.received) > cycle_ / 2;
  return late ? std::optional{held_up_} : std::nullopt;
}

}  // namespace truepose::daemon
