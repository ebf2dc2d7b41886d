#include "drivers/mock/virtual_clock.hpp"

#include <boost/asio/error.hpp>
#include <boost/asio/redirect_error.hpp>
#include <boost/asio/this_coro.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <boost/system/system_error.hpp>

namespace truepose::drivers {

namespace asio = boost::asio;

asio::awaitable<void> VirtualClock::sleep_until(TimePoint when) {
  const auto executor = co_await asio::this_coro::executor;
  WakeUp wake_up{executor, 1};
  const Key key{std::max(when, now_), count_++};
  sleepers_.emplace(key, &wake_up);
  // Also when the coroutine is destroyed in its sleep.
  struct Leave {
    VirtualClock& clock;
    Key key;
    ~Leave() { clock.sleepers_.erase(key); }
  } leave{*this, key};

  boost::system::error_code failed;
  auto token = asio::redirect_error(asio::use_awaitable, failed);
  co_await wake_up.async_receive(token);
  if (failed) throw boost::system::system_error{asio::error::operation_aborted};
}

bool VirtualClock::run(asio::io_context& io, const std::function<bool()>& done) {
  while (true) {
    io.restart();
    while (io.poll_one() != 0) {
      if (done()) return true;
    }
    if (done()) return true;
    if (sleepers_.empty()) return false;
    wake_first();
  }
}

std::optional<TimePoint> VirtualClock::next_wake() const {
  return sleepers_.empty() ? std::nullopt : std::optional{sleepers_.begin()->first.first};
}

void VirtualClock::wake_first() {
  const auto first = sleepers_.begin();
  now_ = std::max(now_, first->first.first);
  WakeUp* const sleeper = first->second;
  sleepers_.erase(first);
  sleeper->try_send(boost::system::error_code{});
}

}  // namespace truepose::drivers
