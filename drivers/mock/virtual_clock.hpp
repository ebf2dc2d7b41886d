#pragma once

#include <algorithm>
#include <boost/asio/experimental/channel.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/system/error_code.hpp>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <utility>

#include "drivers/clock.hpp"

namespace truepose::drivers {

/// A clock that stands still while anything is ready to run, and then jumps to the next sleeper: a week of a
/// cell in a minute, the same every time. One thread.
class VirtualClock final : public Clock {
 public:
  explicit VirtualClock(TimePoint begin = {}) : now_{begin} {}

  TimePoint now() const override { return now_; }
  boost::asio::awaitable<void> sleep_until(TimePoint when) override;

  /// Runs the handlers of `io`, moving time where none is ready, until `done`.
  ///
  /// @return false where nothing is left to run or to wait for, and `done` is still false
  bool run(boost::asio::io_context& io, const std::function<bool()>& done);

  std::size_t sleepers() const { return sleepers_.size(); }

  // For a caller that advances the time itself:
  /// When the next sleeper is to wake.
  std::optional<TimePoint> next_wake() const;
  /// Moves time to the next sleeper, who is ready then. There is one.
  void wake_first();
  /// Advances the time without waking a waiter. A time that has passed changes nothing.
  void pass_to(TimePoint when) { now_ = std::max(now_, when); }

 private:
  using WakeUp = boost::asio::experimental::channel<void(boost::system::error_code)>;
  /// Those who sleep until the same moment wake in the order in which they went to sleep.
  using Key = std::pair<TimePoint, std::uint64_t>;

  TimePoint now_;
  std::uint64_t count_ = 0;
  std::map<Key, WakeUp*> sleepers_;
};

}  // namespace truepose::drivers
