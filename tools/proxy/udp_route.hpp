#pragma once

#include <boost/asio/any_io_executor.hpp>
#include <boost/asio/ip/udp.hpp>
#include <memory>

#include "tools/proxy/route.hpp"

namespace truepose::proxy {

/// Throws boost::system::system_error where the address cannot be listened on.
std::unique_ptr<Route> udp_route(const boost::asio::any_io_executor& executor,
                                 const boost::asio::ip::udp::endpoint& listen,
                                 const boost::asio::ip::udp::endpoint& target, Random& seeds);

}  // namespace truepose::proxy
