#pragma once

#include <sys/socket.h>

#include <boost/asio/any_io_executor.hpp>
#include <boost/asio/co_spawn.hpp>
#include <boost/asio/detached.hpp>
#include <boost/asio/ip/address.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <expected>
#include <functional>
#include <memory>
#include <string>
#include <utility>

#include "config/cell_config.hpp"
#include "drivers/accept_all.hpp"
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
/// @param acceptor  kept until then, as is the server that it is a part of
/// @param who       for messages
/// @param admit     of a socket
template <typename Acceptor, typename Admit>
void accept_all(std::shared_ptr<Acceptor> acceptor, std::function<void(const std::string&)> warn,
                std::string who, Admit admit) {
  const auto admit_who_stayed = [admit = std::move(admit)](auto socket) {
    if (!has_left(socket)) admit(std::move(socket));
  };
  const auto warn_of_it = [warn = std::move(warn), who = std::move(who)](const std::string& what) {
    warn(who + ": " + what);
  };
  boost::asio::co_spawn(acceptor->get_executor(), drivers::accept_all(acceptor, admit_who_stayed, warn_of_it),
                        boost::asio::detached);
}

}  // namespace truepose::daemon
