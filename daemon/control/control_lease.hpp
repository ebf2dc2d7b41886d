#pragma once

#include <chrono>
#include <expected>
#include <functional>
#include <optional>
#include <string>

#include "daemon/control/caller.hpp"
#include "drivers/clock.hpp"
#include "proto/control/request.hpp"

namespace truepose::daemon {

/// Who is in command. While one user holds control, no other user's commands are carried out, except those
/// that take motion, a correction or control away. It ends where it is not renewed in time, is given back, or
/// taken over by a higher role, where its holder is let in no more, and a while after his last connection. A
/// caller is known by its name: a panel that comes back continues. Pure: time is given.
class ControlLease {
 public:
  static constexpr std::chrono::seconds kUsual{30};
  static constexpr std::chrono::seconds kUnconnected{10};  ///< for which it is kept without a connection

  struct Holder {
    Caller who;
    drivers::TimePoint until;
    std::optional<drivers::TimePoint> unconnected_since{};

    drivers::TimePoint end() const;
  };
  /// That control ended without its holder's doing.
  struct Loss {
    std::string name;
    std::string why;  ///< one sentence, which says the name
  };
  using Taken = std::expected<Holder, control::RpcError>;

  /// None if no user has it, or the time is over.
  std::optional<Holder> holder(drivers::TimePoint now) const;
  /// Takes it where it is free, renews it where it is the caller's own.
  Taken acquire(const Caller& caller, std::chrono::seconds time, drivers::TimePoint now);
  /// Takes it from a lower role too.
  Taken take_over(const Caller& caller, std::chrono::seconds time, drivers::TimePoint now);
  bool is_held_by(const Caller& caller, drivers::TimePoint now) const;
  /// @return whether the caller had it
  bool release(const Caller& caller, drivers::TimePoint now);
  /// Why the caller's command is not carried out.
  std::optional<control::RpcError> refusal(const Caller& caller, drivers::TimePoint now) const;
  /// Takes note of whether the holder has a connection.
  void see_connections(drivers::TimePoint now, const std::function<bool(const Caller& who)>& is_connected);
  /// When it ends unless it is renewed.
  std::optional<drivers::TimePoint> end() const;
  /// Whether it has ended since the last call without the holder's doing.
  std::optional<Loss> lost(drivers::TimePoint now, const std::function<bool(const Caller& who)>& is_known);

 private:
  std::optional<Holder> holder_;
};

}  // namespace truepose::daemon
