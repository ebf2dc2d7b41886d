#pragma once

#include <boost/asio/awaitable.hpp>
#include <cstdint>
#include <exception>
#include <expected>

#include "daemon/recorder/driver_call.hpp"
#include "drivers/wire_tap.hpp"

namespace truepose::daemon {

/// A call of a driver whose outcome a tap hears.
/// @param tap  outlives it
template <typename T, typename Error>
boost::asio::awaitable<std::expected<T, Error>> recorded_outcome(
    const drivers::WireTap& tap, std::uint64_t number, boost::asio::awaitable<std::expected<T, Error>> call) {
  try {
    std::expected<T, Error> outcome = co_await std::move(call);
    tap(recording::Kind::Outcome, outcome_text(number, outcome));
    co_return outcome;
  } catch (...) {
    tap(recording::Kind::Outcome, outcome_text(number, std::current_exception()));
    throw;
  }
}

}  // namespace truepose::daemon
