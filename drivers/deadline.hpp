#pragma once

#include <boost/asio/awaitable.hpp>
#include <boost/asio/co_spawn.hpp>
#include <boost/asio/deferred.hpp>
#include <boost/asio/experimental/parallel_group.hpp>
#include <boost/asio/this_coro.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <exception>
#include <optional>
#include <utility>

#include "drivers/clock.hpp"

namespace truepose::drivers {

/// Runs `operation` until the deadline.
///
/// @return what it returned; empty if the deadline came first: then it has been cancelled and has ended.
/// What it throws passes through; cancelling the caller cancels both and throws operation_aborted.
template <typename T>
boost::asio::awaitable<std::optional<T>> before(Clock& clock, TimePoint deadline,
                                                boost::asio::awaitable<T> operation) {
  namespace asio = boost::asio;
  const auto executor = co_await asio::this_coro::executor;
  // Not operator||: that waits for the timer when the operation throws.
  auto race = asio::experimental::make_parallel_group(
      asio::co_spawn(executor, std::move(operation), asio::deferred),
      asio::co_spawn(executor, clock.sleep_until(deadline), asio::deferred));
  auto [order, operation_error, value, timer_error] =
      co_await race.async_wait(asio::experimental::wait_for_one(), asio::use_awaitable);
  if (!operation_error) co_return std::move(value);  // even if both ended at once: a result is never dropped
  if (order[0] == 0) std::rethrow_exception(operation_error);
  if (timer_error) std::rethrow_exception(timer_error);
  co_return std::nullopt;
}

}  // namespace truepose::drivers
