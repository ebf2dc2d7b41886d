#pragma once

#include <functional>
#include <memory>
#include <string>

#include "drivers/net/listener.hpp"
#include "drivers/net/network.hpp"

namespace truepose::steering {

/// Accepts clients until the listener is closed; reports failures on standard error.
/// @param listener  kept until then, as is what it may be a part of
/// @param port      for messages: "EKI"
void accept_clients(std::shared_ptr<net::Listener> listener, std::string port,
                    std::function<void(std::unique_ptr<net::Stream>)> admit);

/// Listens for TCP connections. Throws boost::system::system_error where that cannot be.
/// @param port  0 picks a free one
std::shared_ptr<net::Listener> listen_or_throw(const boost::asio::any_io_executor& executor,
                                               const std::string& address, std::uint16_t port,
                                               const net::Network& network = {});

}  // namespace truepose::steering
