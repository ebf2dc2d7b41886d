#pragma once

#include <boost/asio/ip/tcp.hpp>
#include <functional>
#include <memory>
#include <string>

namespace truepose::steering {

/// Accepts clients until the acceptor is closed; reports failures on standard error.
/// @param acceptor  kept until then, as is what it may be a part of
/// @param port      for messages: "EKI"
void accept_clients(std::shared_ptr<boost::asio::ip::tcp::acceptor> acceptor, std::string port,
                    std::function<void(boost::asio::ip::tcp::socket)> admit);

}  // namespace truepose::steering
