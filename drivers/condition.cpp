#include "drivers/condition.hpp"

#include <boost/asio/as_tuple.hpp>
#include <boost/asio/experimental/channel.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <boost/system/error_code.hpp>

namespace truepose::drivers {

namespace asio = boost::asio;

struct Condition::Channel {
  explicit Channel(const asio::any_io_executor& executor) : its{executor} {}
  asio::experimental::channel<void(boost::system::error_code)> its;
};

Condition::Condition(const asio::any_io_executor& executor) : channel_{std::make_unique<Channel>(executor)} {}
Condition::Condition(Condition&&) noexcept = default;
Condition::~Condition() = default;

asio::awaitable<void> Condition::wait() {
  const auto waited = co_await channel_->its.async_receive(asio::as_tuple(asio::use_awaitable));
  static_cast<void>(waited);
}

void Condition::notify() { channel_->its.cancel(); }

}  // namespace truepose::drivers
