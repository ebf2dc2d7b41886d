#pragma once

#include <boost/asio/any_io_executor.hpp>
#include <memory>

#include "drivers/net/stream.hpp"
#include "tools/proxy/route.hpp"

namespace truepose::proxy {

/// Throws boost::system::system_error where the address cannot be listened on.
/// @param target  numeric, as is where it listens
std::unique_ptr<Route> tcp_route(const boost::asio::any_io_executor& executor, const net::Stream::End& listen,
                                 const net::Stream::End& target, Random& seeds);

}  // namespace truepose::proxy
