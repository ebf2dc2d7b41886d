#pragma once

#include <boost/asio/awaitable.hpp>
#include <boost/asio/co_spawn.hpp>
#include <boost/asio/deferred.hpp>
#include <boost/asio/error.hpp>
#include <boost/asio/experimental/parallel_group.hpp>
#include <boost/asio/this_coro.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <boost/system/system_error.hpp>
#include <exception>
#include <optional>
#include <utility>

#include "drivers/clock.hpp"

namespace truepose::drivers {

/// Runs `operation` until `end` returns.
///
/// @return what it returned; empty if the end came first: then it has been cancelled and has ended.
/// What it throws passes through. Cancelling the caller cancels both and throws operation_aborted, also where
/// the operation itself reports the cancellation as a value.
template <typename T>
boost::asio::awaitable<std::optional<T>> unless(boost::asio::awaitable<void> end,
                                                boost::asio::awaitable<T> operation) {
  namespace asio = boost::asio;
  const auto executor = co_await asio::this_coro::executor;
  // Not operator||: that waits for the end when the operation throws.
  auto race =
      asio::experimental::make_parallel_group(asio::co_spawn(executor, std::move(operation), asio::deferred),
                                              asio::co_spawn(executor, std::move(end), asio::deferred));
  auto [order, operation_error, value, end_error] =
      co_await race.async_wait(asio::experimental::wait_for_one(), asio::use_awaitable);
  const auto caller = co_await asio::this_coro::cancellation_state;
  if (caller.cancelled() != asio::cancellation_type::none) {
    throw boost::system::system_error{asio::error::operation_aborted};
  }
  const bool operation_first = order[0] == 0;
  const std::exception_ptr error = operation_first ? operation_error : end_error;
  if (error) std::rethrow_exception(error);
  if (!operation_first) co_return std::nullopt;
  co_return std::move(value);
}

/// The same until the deadline.
template <typename T>
boost::asio::awaitable<std::optional<T>> before(Clock& clock, TimePoint deadline,
                                                boost::asio::awaitable<T> operation) {
  return unless(clock.sleep_until(deadline), std::move(operation));
}

}  // namespace truepose::drivers
