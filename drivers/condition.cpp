#include "drivers/condition.hpp"

#include <boost/asio/as_tuple.hpp>
#include <boost/asio/use_awaitable.hpp>

namespace truepose::drivers {

namespace asio = boost::asio;

asio::awaitable<void> Condition::wait() {
  const auto waited = co_await channel_.async_receive(asio::as_tuple(asio::use_awaitable));
  static_cast<void>(waited);
}

}  // namespace truepose::drivers
