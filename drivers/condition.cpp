#include "drivers/condition.hpp"

#include <boost/asio/as_tuple.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/use_awaitable.hpp>

namespace truepose::drivers {

namespace asio = boost::asio;

struct Condition::Timer : asio::steady_timer {
  using asio::steady_timer::steady_timer;
};

Condition::Condition(const asio::any_io_executor& executor)
    : timer_{std::make_unique<Timer>(executor, asio::steady_timer::time_point::max())} {}
Condition::Condition(Condition&&) noexcept = default;
Condition::~Condition() = default;

asio::awaitable<void> Condition::wait() {
  const auto waited = co_await timer_->async_wait(asio::as_tuple(asio::use_awaitable));
  static_cast<void>(waited);
}

void Condition::notify() { timer_->cancel(); }

}  // namespace truepose::drivers
