#pragma once

#include <boost/asio/awaitable.hpp>
#include <boost/asio/error.hpp>
#include <boost/asio/this_coro.hpp>
#include <boost/system/system_error.hpp>
#include <cstdint>
#include <optional>
#include <utility>

#include "drivers/clock.hpp"
#include "drivers/condition.hpp"
#include "drivers/deadline.hpp"

namespace truepose::daemon {

/// Wakes the coroutines of one thread that wait for something to change. None misses a change that comes
/// after it has asked, begun to wait or not.
class Signal {
 public:
  void notify() {
    ++changes_;
    if (changed_) changed_->notify();
  }
  /// Returns at the next change; throws operation_aborted when cancelled.
  boost::asio::awaitable<void> wait() { return wait_beyond(changes_); }
  /// The same, or at `when`, whichever comes first.
  boost::asio::awaitable<void> wait_until(drivers::Clock& clock, drivers::TimePoint when) {
    return first_of(wait(), clock.sleep_until(when));
  }

 private:
  using Wait = boost::asio::awaitable<void>;

  Wait wait_beyond(std::uint64_t changes) {
    const auto executor = co_await boost::asio::this_coro::executor;
    if (!changed_) changed_.emplace(executor);
    while (changes_ == changes) {
      co_await changed_->wait();
      if (changes_ == changes) throw boost::system::system_error{boost::asio::error::operation_aborted};
    }
  }
  static Wait first_of(Wait change, Wait time) {
    co_await drivers::unless(std::move(time), std::move(change));
  }

  std::uint64_t changes_ = 0;
  std::optional<drivers::Condition> changed_;
};

}  // namespace truepose::daemon
