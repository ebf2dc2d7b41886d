#pragma once

#include <boost/asio/awaitable.hpp>
#include <optional>
#include <utility>

#include "drivers/clock.hpp"

namespace truepose::drivers {

/// Runs `operation` until `end` returns.
///
/// @return whether it has returned; false if the end came first: then it has been cancelled and has ended.
/// What it throws passes through. Cancelling the caller cancels both and throws operation_aborted, also where
/// the operation itself reports the cancellation as a value.
boost::asio::awaitable<bool> unless(boost::asio::awaitable<void> end, boost::asio::awaitable<void> operation);

/// Runs `operation` for its result.
template <typename T>
boost::asio::awaitable<void> put_into(std::optional<T>& result, boost::asio::awaitable<T> operation) {
  result.emplace(co_await std::move(operation));
}

/// The same as `unless` above. @return what the operation returned; empty if the end came first
template <typename T>
boost::asio::awaitable<std::optional<T>> unless(boost::asio::awaitable<void> end,
                                                boost::asio::awaitable<T> operation) {
  std::optional<T> result;
  const bool returned = co_await unless(std::move(end), put_into(result, std::move(operation)));
  if (!returned) result.reset();
  co_return result;
}

/// The same until the deadline.
inline boost::asio::awaitable<bool> before(Clock& clock, TimePoint deadline,
                                           boost::asio::awaitable<void> operation) {
  return unless(clock.sleep_until(deadline), std::move(operation));
}
template <typename T>
boost::asio::awaitable<std::optional<T>> before(Clock& clock, TimePoint deadline,
                                                boost::asio::awaitable<T> operation) {
  return unless(clock.sleep_until(deadline), std::move(operation));
}

}  // namespace truepose::drivers
