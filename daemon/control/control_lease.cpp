#include "daemon/control/control_lease.hpp"

#include <algorithm>
#include <utility>

#include "core/planted_bug.hpp"

namespace truepose::daemon {

using control::ErrorCode;
using control::RpcError;
using drivers::TimePoint;

TimePoint ControlLease::Holder::end() const {
  return unconnected_since ? std::min(until, *unconnected_since + kUnconnected) : until;
}

std::optional<ControlLease::Holder> ControlLease::holder(TimePoint now) const {
  if (!holder_ || (now >= holder_->end() && !planted("control never ends"))) return std::nullopt;
  return holder_;
}

std::optional<RpcError> ControlLease::refusal(const Caller& caller, TimePoint now) const {
  const auto held = holder(now);
  if (!held || held->who.name == caller.name) return std::nullopt;
  const auto left = std::chrono::ceil<std::chrono::seconds>(held->end() - now);
  return RpcError{ErrorCode::NotInControl, held->who.name + " (" +
                                               std::string{control::name(held->who.role)} +
                                               ") has control, for " + std::to_string(left.count()) +
                                               " s more unless it is renewed; a higher role takes it over by "
                                               "control.takeover"};
}

ControlLease::Taken ControlLease::acquire(const Caller& caller, std::chrono::seconds time, TimePoint now) {
  if (auto refused = refusal(caller, now)) return std::unexpected(*std::move(refused));
  holder_ = Holder{caller, now + time};
  return *holder_;
}

ControlLease::Taken ControlLease::take_over(const Caller& caller, std::chrono::seconds time, TimePoint now) {
  const auto held = holder(now);
  if (held && held->who.role < caller.role) holder_.reset();
  return acquire(caller, time, now);
}

bool ControlLease::is_held_by(const Caller& caller, TimePoint now) const {
  const auto held = holder(now);
  return held && held->who.name == caller.name;
}

bool ControlLease::release(const Caller& caller, TimePoint now) {
  if (!is_held_by(caller, now)) return false;
  holder_.reset();
  return true;
}

void ControlLease::see_connections(TimePoint now,
                                   const std::function<bool(const Caller& who)>& is_connected) {
  if (!holder(now)) return;
  std::optional<TimePoint>& since = holder_->unconnected_since;
  if (is_connected(holder_->who)) {
    since.reset();
  } else if (!since) {
    since = now;
  }
}

std::optional<TimePoint> ControlLease::end() const {
  return holder_ ? std::optional{holder_->end()} : std::nullopt;
}

std::optional<ControlLease::Loss> ControlLease::lost(TimePoint now,
                                                     const std::function<bool(const Caller& who)>& is_known) {
  if (!holder_) return std::nullopt;
  const bool known = is_known(holder_->who);
  if (known && (now < holder_->end() || planted("control never ends"))) return std::nullopt;
  const Holder last = *std::exchange(holder_, std::nullopt);
  const std::string& name = last.who.name;
  if (!known) return Loss{name, "the access of " + name + ", who had control, was changed or revoked"};
  if (last.end() == last.until) return Loss{name, name + " has not renewed its control"};
  return Loss{name, "the last connection of " + name + ", who had control, ended " +
                        std::to_string(kUnconnected.count()) + " s ago"};
}

}  // namespace truepose::daemon
