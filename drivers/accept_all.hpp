#pragma once

#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/local/stream_protocol.hpp>
#include <functional>
#include <memory>
#include <string>

namespace truepose::drivers {

/// Of why no connection can be accepted: "cannot accept a connection: Too many open files".
using Warn = std::function<void(const std::string&)>;

/// Accepts on the acceptor's executor until the acceptor is closed.
/// @param acceptor  kept until then, as is what it may be a part of
void accept_all(std::shared_ptr<boost::asio::ip::tcp::acceptor> acceptor,
                std::function<void(boost::asio::ip::tcp::socket)> admit, Warn warn);
void accept_all(std::shared_ptr<boost::asio::local::stream_protocol::acceptor> acceptor,
                std::function<void(boost::asio::local::stream_protocol::socket)> admit, Warn warn);

}  // namespace truepose::drivers
