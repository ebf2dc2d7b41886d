#include "drivers/clock.hpp"

#include <boost/asio/steady_timer.hpp>
#include <boost/asio/this_coro.hpp>
#include <boost/asio/use_awaitable.hpp>

namespace truepose::drivers {

TimePoint SteadyClock::now() const { return std::chrono::steady_clock::now(); }

boost::asio::awaitable<void> SteadyClock::sleep_until(TimePoint when) {
  const auto executor = co_await boost::asio::this_coro::executor;
  boost::asio::steady_timer timer{executor, when};
  co_await timer.async_wait(boost::asio::use_awaitable);
}

}  // namespace truepose::drivers
