#include "daemon/control/acceptor.hpp"

#include <boost/asio/error.hpp>
#include <utility>

#include "config/number_text.hpp"
#include "drivers/port_holder.hpp"

namespace truepose::daemon {

using drivers::StartFailure;

std::expected<std::shared_ptr<net::Listener>, StartFailure> listen(
    const net::Network& network, const boost::asio::any_io_executor& executor, const std::string& key,
    const config::Endpoint& endpoint, const std::expected<boost::asio::ip::address, std::string>& address) {
  const std::string where = key + ": " + config::text(endpoint);
  if (!address) return std::unexpected(address.error());
  auto listener = network.listen_tcp(executor, address->to_string(), endpoint.port, {});
  if (listener) return *std::move(listener);
  if (listener.error() == boost::asio::error::address_in_use)
    return std::unexpected(StartFailure{
        where + " is in use by " + drivers::port_holder(drivers::Protocol::Tcp, endpoint.port), true});
  const bool may_pass = listener.error() == boost::system::errc::address_not_available;
  return std::unexpected(StartFailure{where + ": " + listener.error().message(), may_pass});
}

void accept_who_stays(std::shared_ptr<net::Listener> listener, net::Warn warn, const std::string& server,
                      std::function<void(std::unique_ptr<net::Stream>)> admit) {
  const auto admit_who_stays = [admit = std::move(admit)](std::unique_ptr<net::Stream> stream) {
    if (!net::has_left(*stream)) admit(std::move(stream));
  };
  const auto warn_of_it = [warn = std::move(warn), server](const std::string& what) {
    warn(server + ": " + what);
  };
  net::accept_all(std::move(listener), admit_who_stays, warn_of_it);
}

}  // namespace truepose::daemon
