#pragma once

#include <boost/asio/any_io_executor.hpp>
#include <boost/asio/awaitable.hpp>
#include <boost/asio/cancellation_signal.hpp>
#include <exception>
#include <functional>

namespace truepose::net {

/// @param failed  what it threw; null: it has returned
using Ended = std::function<void(std::exception_ptr failed)>;

/// For work whose failure ends the program.
inline void rethrow(std::exception_ptr failed) {
  if (failed) std::rethrow_exception(failed);
}

/// Runs a coroutine on the executor, while its caller goes on.
/// @param ended  called there at its end; empty: what it throws is dropped
/// @param slot   through which it is cancelled
void spawn(const boost::asio::any_io_executor& executor, boost::asio::awaitable<void> work, Ended ended = {},
           boost::asio::cancellation_slot slot = {});

}  // namespace truepose::net
