#include "drivers/net/spawn.hpp"

#include <boost/asio/bind_cancellation_slot.hpp>
#include <boost/asio/co_spawn.hpp>
#include <utility>

namespace truepose::net {

void spawn(const boost::asio::any_io_executor& executor, boost::asio::awaitable<void> work, Ended ended,
           boost::asio::cancellation_slot slot) {
  if (!ended) ended = [](std::exception_ptr) {};
  boost::asio::co_spawn(executor, std::move(work),
                        boost::asio::bind_cancellation_slot(slot, std::move(ended)));
}

}  // namespace truepose::net
