#include "drivers/deadline.hpp"

#include <boost/asio/co_spawn.hpp>
#include <boost/asio/deferred.hpp>
#include <boost/asio/error.hpp>
#include <boost/asio/experimental/parallel_group.hpp>
#include <boost/asio/this_coro.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <boost/system/system_error.hpp>
#include <exception>

namespace truepose::drivers {

namespace asio = boost::asio;

asio::awaitable<bool> unless(asio::awaitable<void> end, asio::awaitable<void> operation) {
  const auto executor = co_await asio::this_coro::executor;
  // Not operator||: that waits for the end when the operation throws.
  auto race =
      asio::experimental::make_parallel_group(asio::co_spawn(executor, std::move(operation), asio::deferred),
                                              asio::co_spawn(executor, std::move(end), asio::deferred));
  const auto [order, operation_error, end_error] =
      co_await race.async_wait(asio::experimental::wait_for_one(), asio::use_awaitable);
  const auto caller = co_await asio::this_coro::cancellation_state;
  if (caller.cancelled() != asio::cancellation_type::none)
    throw boost::system::system_error{asio::error::operation_aborted};
  const bool returned = order[0] == 0;
  if (const std::exception_ptr& error = returned ? operation_error : end_error) std::rethrow_exception(error);
  co_return returned;
}

}  // namespace truepose::drivers
