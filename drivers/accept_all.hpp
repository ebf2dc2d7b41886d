#pragma once

#include <boost/asio/as_tuple.hpp>
#include <boost/asio/awaitable.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <chrono>
#include <memory>
#include <string>
#include <utility>

namespace truepose::drivers {

/// Accepts until the acceptor is closed.
/// @param acceptor  kept until then, as is what it may be a part of
/// @param admit     of a socket
/// @param warn      of why nobody can be admitted: "cannot accept a connection: Too many open files"
template <typename Acceptor, typename Admit, typename Warn>
boost::asio::awaitable<void> accept_all(std::shared_ptr<Acceptor> acceptor, Admit admit, Warn warn) {
  namespace asio = boost::asio;
  constexpr auto kToResult = asio::as_tuple(asio::use_awaitable);
  while (acceptor->is_open()) {
    auto [error, socket] = co_await acceptor->async_accept(kToResult);
    if (!acceptor->is_open()) co_return;
    if (!error) {
      admit(std::move(socket));
      continue;
    }
    // Out of file descriptors, mostly: trying again at once would only burn the processor.
    warn("cannot accept a connection: " + error.message());
    asio::steady_timer later{acceptor->get_executor(), std::chrono::milliseconds{100}};
    co_await later.async_wait(asio::use_awaitable);
  }
}

}  // namespace truepose::drivers
