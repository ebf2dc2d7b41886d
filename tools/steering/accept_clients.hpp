#pragma once

#include <boost/asio/ip/tcp.hpp>
#include <functional>
#include <memory>
#include <string>

namespace truepose::steering {

/// Admits whoever connects until the acceptor is closed; what keeps it from that is told on standard error.
/// @param acceptor  kept until then, as is what it may be a part of
/// @param port      for messages: "EKI"
void accept_clients(std::shared_ptr<boost::asio::ip::tcp::acceptor> acceptor, std::string port,
                    std::function<void(boost::asio::ip::tcp::socket)> admit);

}  // namespace truepose::steering
