#include "daemon/control/acceptor.hpp"

#include "config/number_text.hpp"
#include "drivers/port_holder.hpp"

namespace truepose::daemon {

namespace asio = boost::asio;
using asio::ip::tcp;
using drivers::StartFailure;

std::expected<tcp::acceptor, StartFailure> listen(
    asio::any_io_executor executor, const std::string& key, const config::Endpoint& endpoint,
    const std::expected<asio::ip::address, std::string>& address) {
  const std::string where = key + ": " + config::text(endpoint);
  if (!address) return std::unexpected(address.error());
  const tcp::endpoint local{*address, endpoint.port};
  boost::system::error_code error;
  tcp::acceptor acceptor{executor};
  acceptor.open(local.protocol(), error);
  // The port may still have connections of the daemon before us that are closing.
  if (!error) acceptor.set_option(tcp::acceptor::reuse_address{true}, error);
  if (!error) acceptor.bind(local, error);
  if (!error) acceptor.listen(tcp::acceptor::max_listen_connections, error);
  if (error == asio::error::address_in_use)
    return std::unexpected(StartFailure{
        where + " is in use by " + drivers::port_holder(drivers::Protocol::Tcp, endpoint.port), true});
  const bool may_pass = error == boost::system::errc::address_not_available;
  if (error) return std::unexpected(StartFailure{where + ": " + error.message(), may_pass});
  return acceptor;
}

}  // namespace truepose::daemon
