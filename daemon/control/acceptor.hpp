#pragma once

#include <boost/asio/any_io_executor.hpp>
#include <boost/asio/ip/address.hpp>
#include <expected>
#include <functional>
#include <memory>
#include <string>

#include "config/cell_config.hpp"
#include "drivers/net/network.hpp"
#include "drivers/start_failure.hpp"

namespace truepose::daemon {

/// Listens for TCP connections.
/// @param key      of the cell file, for messages
/// @param address  of the endpoint, or what is wrong with it
std::expected<std::shared_ptr<net::Listener>, drivers::StartFailure> listen(
    const net::Network& network, const boost::asio::any_io_executor& executor, const std::string& key,
    const config::Endpoint& endpoint, const std::expected<boost::asio::ip::address, std::string>& address);

/// Accepts until the listener is closed, but leaves out a client that has hung up and sent nothing: to serve
/// it takes a hundred times as long, and others wait behind it.
/// @param listener  kept until then, as is the server that it is a part of
/// @param server    for messages
void accept_who_stays(std::shared_ptr<net::Listener> listener, net::Warn warn, const std::string& server,
                      std::function<void(std::unique_ptr<net::Stream>)> admit);

}  // namespace truepose::daemon
