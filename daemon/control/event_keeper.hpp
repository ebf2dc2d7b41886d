#pragma once

#include <boost/asio/awaitable.hpp>
#include <chrono>
#include <functional>
#include <optional>

#include "daemon/control/event_bus.hpp"
#include "daemon/threads/worker.hpp"
#include "drivers/clock.hpp"

namespace truepose::daemon {

/// Brings events from the bus into its archive, some at a time, so that a point that is to be stored never
/// waits for more than one of these writes, and forgets those of more than 90 days ago, the newest 10,000
/// excepted.
class EventKeeper {
 public:
  static constexpr std::chrono::days kKept{90};

  struct Parts {
    EventBus& events;  ///< with an archive
    Worker& worker;    ///< the only one that touches the archive
    drivers::Clock& clock;
    drivers::WallClock wall_clock;
    /// Called where the archive takes nothing, each time that it was tried.
    std::function<void(const StoreError& error)> failed;
  };
  /// All of it outlives the keeper.
  explicit EventKeeper(Parts parts) : parts_{std::move(parts)} {}

  /// Writes once a second what has come, and continues where that fails. Ends when cancelled.
  boost::asio::awaitable<void> run();

 private:
  boost::asio::awaitable<void> write();
  boost::asio::awaitable<void> prune();

  Parts parts_;
  drivers::TimePoint prune_at_{};
};

}  // namespace truepose::daemon
