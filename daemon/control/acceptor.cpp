#include "daemon/control/acceptor.hpp"

#include <sys/socket.h>

#include <utility>

#include "config/number_text.hpp"
#include "drivers/port_holder.hpp"

namespace truepose::daemon {

namespace asio = boost::asio;
using asio::ip::tcp;
using Local = asio::local::stream_protocol;
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

namespace {

template <typename Acceptor, typename Admit>
void accept_who_stays(std::shared_ptr<Acceptor> acceptor, drivers::Warn warn, const std::string& server,
                      Admit admit) {
  const auto admit_who_stays = [admit = std::move(admit)](typename Acceptor::protocol_type::socket socket) {
    char byte = 0;
    const bool has_left = ::recv(socket.native_handle(), &byte, 1, MSG_PEEK | MSG_DONTWAIT) == 0;
    if (!has_left) admit(std::move(socket));
  };
  const auto warn_of_it = [warn = std::move(warn), server](const std::string& what) {
    warn(server + ": " + what);
  };
  drivers::accept_all(std::move(acceptor), admit_who_stays, warn_of_it);
}

}  // namespace

void accept_all(std::shared_ptr<tcp::acceptor> acceptor, drivers::Warn warn, const std::string& server,
                std::function<void(tcp::socket)> admit) {
  accept_who_stays(std::move(acceptor), std::move(warn), server, std::move(admit));
}

void accept_all(std::shared_ptr<Local::acceptor> acceptor, drivers::Warn warn, const std::string& server,
                std::function<void(Local::socket)> admit) {
  accept_who_stays(std::move(acceptor), std::move(warn), server, std::move(admit));
}

}  // namespace truepose::daemon
