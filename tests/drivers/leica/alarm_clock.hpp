#pragma once

#include <boost/asio/as_tuple.hpp>
#include <boost/asio/cancellation_state.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/this_coro.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <boost/system/system_error.hpp>

#include "drivers/clock.hpp"

namespace truepose::drivers {

/// A clock on which every deadline comes when the test says so, and no sooner.
class AlarmClock final : public Clock {
 public:
  explicit AlarmClock(boost::asio::io_context& io) : alarm_{io, TimePoint::max()} {}

  /// All sleepers wake: their time has come.
  void ring() { alarm_.cancel(); }

  TimePoint now() const override { return {}; }
  boost::asio::awaitable<void> sleep_until(TimePoint) override {
    namespace asio = boost::asio;
    co_await alarm_.async_wait(asio::as_tuple(asio::use_awaitable));
    const asio::cancellation_state state = co_await asio::this_coro::cancellation_state;
    if (state.cancelled() == asio::cancellation_type::none) co_return;
    throw boost::system::system_error(asio::error::operation_aborted);
  }

 private:
  boost::asio::steady_timer alarm_;
};

}  // namespace truepose::drivers
