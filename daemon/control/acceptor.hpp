#pragma once

#include <boost/asio/any_io_executor.hpp>
#include <boost/asio/ip/address.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/local/stream_protocol.hpp>
#include <expected>
#include <functional>
#include <memory>
#include <string>

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

/// Accepts until the acceptor is closed, but leaves out a client that has hung up and sent nothing: to serve
/// it takes a hundred times as long, and others wait behind it.
/// @param acceptor  kept until then, as is the server that it is a part of
/// @param server    for messages
void accept_all(std::shared_ptr<boost::asio::ip::tcp::acceptor> acceptor, drivers::Warn warn,
                const std::string& server, std::function<void(boost::asio::ip::tcp::socket)> admit);
void accept_all(std::shared_ptr<boost::asio::local::stream_protocol::acceptor> acceptor, drivers::Warn warn,
                const std::string& server,
                std::function<void(boost::asio::local::stream_protocol::socket)> admit);

}  // namespace truepose::daemon
