#pragma once

#include <sys/socket.h>

#include <boost/asio/any_io_executor.hpp>
#include <boost/asio/as_tuple.hpp>
#include <boost/asio/awaitable.hpp>
#include <boost/asio/ip/address.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <expected>
#include <functional>
#include <string>

#include "config/cell_config.hpp"
#include "drivers/clock.hpp"
#include "drivers/start_failure.hpp"

namespace truepose::daemon {

/// Listens for TCP connections.
/// @param key      of the cell file, for messages
/// @param address  of the endpoint, or what is wrong with it
std::expected<boost::asio::ip::tcp::acceptor, drivers::StartFailure> listen(
    boost::asio::any_io_executor executor, const std::string& key, const config::Endpoint& endpoint,
    const std::expected<boost::asio::ip::address, std::string>& address);

/// Whether whoever connected has hung up and said nothing. To serve him would take a hundred times as long as
/// to see that, and others wait behind him.
template <typename Socket>
bool has_left(Socket& socket) {
  char byte = 0;
  return ::recv(socket.native_handle(), &byte, 1, MSG_PEEK | MSG_DONTWAIT) == 0;
}

/// Accepts until the acceptor is closed.
/// @param who    for messages
/// @param admit  of a socket
template <typename Acceptor, typename Admit>
boost::asio::awaitable<void> accept_all(Acceptor& acceptor, drivers::Clock& clock,
                                        std::function<void(const std::string&)> warn, std::string who,
                                        Admit admit) {
  namespace asio = boost::asio;
  while (acceptor.is_open()) {
    auto accepted = co_await acceptor.async_accept(asio::as_tuple(asio::use_awaitable));
    auto& [error, socket] = accepted;
    if (!acceptor.is_open()) co_return;
    if (!error) {
      if (!has_left(socket)) admit(std::move(socket));
      continue;
    }
    // Out of file descriptors, mostly: trying again at once would only burn the processor.
    warn(who + ": cannot accept a connection: " + error.message());
    const drivers::TimePoint later = clock.now() + std::chrono::milliseconds{100};
    co_await clock.sleep_until(later);
  }
}

}  // namespace truepose::daemon
