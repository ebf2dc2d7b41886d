#pragma once

#include <boost/asio/ip/address.hpp>
#include <expected>
#include <string>

#include "config/cell_config.hpp"

namespace truepose::daemon {

/// The address of control.listen. @return it, or why the control port cannot be there and what to do
inline std::expected<boost::asio::ip::address, std::string> control_address(const config::Endpoint& listen) {
  boost::system::error_code error;
  const auto address =
      boost::asio::ip::make_address(listen.host == "localhost" ? "127.0.0.1" : listen.host, error);
  if (error) {
    return std::unexpected("control.listen: \"" + listen.host +
                           "\" is not an IP address: give 127.0.0.1 or ::1");
  }
  if (!address.is_loopback()) {
    return std::unexpected("control.listen: " + listen.host +
                           " can be reached from other machines, which needs TLS; listen on 127.0.0.1");
  }
  return address;
}

}  // namespace truepose::daemon
